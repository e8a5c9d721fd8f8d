#include <cstdio>
#include <cstdlib>
#include <exception>

#include "node.hpp"

int main(int argc, char** argv) {
  using namespace chasles::ros1;
  try {
    Transport transport(argc, argv, "chasles");
    try {
      Node node(transport);
      node.run();
      return EXIT_SUCCESS;
    } catch (const std::exception& error) {
      transport.log(LogLevel::kError, error.what());
    }
  } catch (const std::exception& error) {
    std::fputs(error.what(), stderr);
    std::fputs("\n", stderr);
  }
  return EXIT_FAILURE;
}
