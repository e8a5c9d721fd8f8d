#pragma once

namespace chasles::app {

/// Runs the command and returns its exit code. Prints errors to stderr; throws nothing.
int program(int argc, char** argv);

}  // namespace chasles::app
