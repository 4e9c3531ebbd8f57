#pragma once
// What the tests of optim begin with.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/spec/spec_error.hpp"
#include "optim/job/job.hpp"
#include "support/refusals.hpp"
#include "support/temporary_folder.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;
using nlohmann::json;
namespace fs = std::filesystem;
