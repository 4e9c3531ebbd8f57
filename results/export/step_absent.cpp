// In place of step.cpp in a build without Open CASCADE.
#include "core/spec/spec_error.hpp"
#include "results/export/step.hpp"

namespace flexopt {

StepFile step_file(const Exported&, const PathPoint*) {
  throw SpecError("--format", "step",
                  "this program was built without Open CASCADE: install the package "
                  "libocct-data-exchange-dev and build it again");
}

}  // namespace flexopt
