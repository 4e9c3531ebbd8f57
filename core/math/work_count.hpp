#pragma once

namespace flexopt {

/// How many Newton iterations this thread has counted since it began, within limits
/// (work_limit.hpp) or without.
long long counted_iterations();

}  // namespace flexopt
