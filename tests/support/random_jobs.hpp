#pragma once
// Jobs of random designs of the library's families: lengths over three decades, leaves 5 to 1000
// times as long as thick, strokes and payloads from hardly any to absurd.
#include <nlohmann/json.hpp>
#include <string>

namespace flexopt {

/// Seeds from here on have meshes of 2 x 2 to 6 x 3 elements, some finer ones, and paths of two to
/// four points: a campaign of them takes a fraction of the time.
constexpr unsigned long long first_quick_job = 1000000;

/// The same for the same seed; the families take turns. Not every one is a sensible design: its
/// reader may refuse it.
nlohmann::json random_job(unsigned long long seed);

/// A job of a mechanism of its own, written flat, in SI numbers: one to four bodies on one to six
/// leaves of all kinds, held in any directions, with one to six drives, joints, springs, massless
/// bodies, loads on any body, gravity, warmth, errors of assembly; one in six is a random_design()
/// written flat, with its parts and mirrors. Strokes and loads are as large as a designer's: by the
/// stress that they make in the undeflected mechanism. The stroke is a list under "at". The same
/// for the same seed, as far as that stress is to its second digit. Seeds from first_quick_job on
/// have one to three leaves on coarse meshes, and two points.
nlohmann::json random_own_job(unsigned long long seed);

/// The job of the same mechanism `factor` times as large, of the same material, whose loads and
/// masses grow with it.
nlohmann::json scaled_job(nlohmann::json job, double factor);

/// By which a number of this SI unit grows in such a mechanism: lengths and times by the factor,
/// masses by its cube.
double growth_of(const std::string& unit, double factor);

}  // namespace flexopt
