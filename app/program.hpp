#pragma once

namespace chasles::app {

/// The command from its arguments to its exit code; what is thrown has been told on stderr.
int program(int argc, char** argv);

}  // namespace chasles::app
