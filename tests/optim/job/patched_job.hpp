#pragma once
// Jobs with some members changed.
#include "support/base_jobs.hpp"
#include "tests/optim/optim_tests.hpp"

namespace flexopt {

/// base_job(base) with these members changed; one of null is taken away.
inline json patched(const char* base, const char* patch) {
  json document = base_job(base);
  document.merge_patch(json::parse(patch));
  return document;
}
inline json patched(const char* patch) { return patched("evaluate", patch); }

inline Job read_patched(const char* patch) { return parse_job(patched(patch)); }
/// What base_job("optimise") looks for with these members of its section changed.
inline OptimiseSpec read_search(const char* patch) {
  json document = base_job("optimise");
  document["optimise"].merge_patch(json::parse(patch));
  return *parse_job(document).optimise;
}

}  // namespace flexopt
