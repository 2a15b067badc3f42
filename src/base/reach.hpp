#pragma once
/// How far away anything may be.

namespace berm {

/// From the origin [m]: beyond, differences and squares of coordinates lose their digits.
inline constexpr double farthest_place = 1e10;

}  // namespace berm
