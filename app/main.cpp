#include "program.hpp"

int main(int argc, char** argv) { return chasles::app::program(argc, argv); }
