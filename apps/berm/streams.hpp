#pragma once
/// Standard input, output and errors.

#include <string>

/// Before anything else is opened: makes up for streams that are closed, so that no file of a run takes their place, and turns
/// the signals of a reader that has gone and of the limit of file sizes into errors.
void prepare_streams();

/// Prints to standard output and returns 0, or 1 having said why not (not to a reader that has gone on purpose).
int print_out(const std::string& text);

/// Prints a line to standard error if that takes it; nobody is left to be told otherwise.
void say_error(const std::string& line);

/// Everything that standard input holds. Throws InputError if it cannot be read or is too large for a case.
std::string read_standard_input();
