#include "results/cli/program.hpp"

int main(int argc, char** argv) { return flexopt_program(argc, argv); }
