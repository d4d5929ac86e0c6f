#pragma once

namespace photond {

/// Exit codes of the program.
inline constexpr int kExitOk = 0;
inline constexpr int kExitFailure = 1;  ///< the input or the environment failed
inline constexpr int kExitUsage = 2;    ///< the command line is wrong
inline constexpr int kExitCut = 3;      ///< serve: told to end, it had to before all was put away; nothing is lost

/// Parses the command line, runs the command it names and returns the exit code.
int run_cli(int argc, char** argv);

}  // namespace photond
