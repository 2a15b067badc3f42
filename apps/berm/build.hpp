#pragma once
/// What the program was built from.

/// Short hash of the commit, with "+" after it where files had been changed; empty without git.
extern const char* const build_commit;
