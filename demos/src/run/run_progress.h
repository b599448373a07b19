/// How far a run is: a bar on a terminal, a line now and then in a log.
#pragma once

#include <string>

namespace bsoil::scene {

/// Where a run stands.
struct Progress {
    long long step_count = 0, step_target = 1;  ///< of the whole run
    long long step_first = 0;                   ///< steps that were made before this process
    double time_s = 0;                          ///< simulated
    double wall_s = 0;                          ///< since this process began to step
};

int percent_of(const Progress& progress);
/// Wall time still to go [s], at the mean speed so far; negative before the first step.
double remaining_s(const Progress& progress);
/// "12 s", "3 min 05 s", "2 h 07 min".
std::string duration_text(double seconds);
/// " 40%  2.40 s simulated, 12 s, 18 s to go".
std::string progress_text(const Progress& progress);

/// Decides when a log gets a line: at each tenth of the run, but no two lines in less than 10 s;
/// and every minute in any case.
class LogCadence {
  public:
    bool is_due(const Progress& progress);

  private:
    int tenth_ = 0;
    double last_s_ = 0;
};

}  // namespace bsoil::scene
