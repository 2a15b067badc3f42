#include "base/time_function.hpp"

#include <fmt/format.h>
#include <muParser.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "base/error.hpp"

namespace berm {

struct TimeFunction::Expression {
  std::string text, key;
  bool depends_on_place = false;
  // muParser reads its variables through pointers.
  mutable double t = 0.0;
  mutable Vec3 x = Vec3::Zero();
  mu::Parser parser;
};

namespace {

/// muParser takes "t = 5" for an assignment to t.
bool assigns(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i)
    if (text[i] == '=' && (i == 0 || std::string_view("=<>!").find(text[i - 1]) == std::string_view::npos) &&
        (i + 1 == text.size() || text[i + 1] != '='))
      return true;
  return false;
}

}  // namespace

TimeFunction::TimeFunction(const std::string& text, std::string key) {
  const auto expression = std::make_shared<Expression>();
  expression->text = text;
  expression->key = std::move(key);
  mu::Parser& parser = expression->parser;
  if (assigns(text)) throw std::invalid_argument(fmt::format("\"{}\": = means nothing here (equal is ==)", text));
  if (std::any_of(text.begin(), text.end(), [](unsigned char c) { return std::iscntrl(c) && !std::isspace(c); }))
    throw std::invalid_argument("an expression has a character that cannot be seen");
  bool constant = false;
  double value = 0.0;
  try {
    parser.DefineVar("t", &expression->t);
    parser.DefineVar("x", &expression->x[0]);
    parser.DefineVar("y", &expression->x[1]);
    parser.DefineVar("z", &expression->x[2]);
    parser.DefineConst("pi", std::numbers::pi);
    parser.SetExpr(text);
    for (const auto& used : parser.GetUsedVar()) expression->depends_on_place |= used.first != "t";
    constant = parser.GetUsedVar().empty();
    value = parser.Eval();
  } catch (const mu::Parser::exception_type& error) {
    const bool no_words = error.GetCode() == mu::ecINTERNAL_ERROR;
    throw std::invalid_argument(fmt::format("\"{}\": {}", text, no_words ? "is no expression: an operator, or a bracket, is too many" : error.GetMsg()));
  }
  if (parser.GetNumResults() != 1)
    throw std::invalid_argument(
        fmt::format("\"{}\" has more than one value (decimal comma instead of a point?)", text));
  if (constant && !std::isfinite(value)) throw std::invalid_argument(fmt::format("\"{}\" is {}", text, value));
  expression_ = expression;
}

double TimeFunction::at(double t, const Vec3& x) const {
  if (!expression_) return t < end_ ? value_ * (t / end_) : value_;
  expression_->t = t;
  expression_->x = origin_ + x;
  const double value = expression_->parser.Eval();
  if (!std::isfinite(value))
    throw RunError(fmt::format("{}: \"{}\" is {} at t = {:.6g} s{}", expression_->key, expression_->text, value, t,
                               depends_on_place() ? fmt::format(", ({:.6g}, {:.6g}, {:.6g})", expression_->x.x(), expression_->x.y(), expression_->x.z()) : ""));
  return value;
}

bool TimeFunction::depends_on_place() const { return expression_ && expression_->depends_on_place; }

const std::string& TimeFunction::text() const {
  static const std::string none;
  return expression_ ? expression_->text : none;
}

}  // namespace berm
