#pragma once
// What the tests of results begin with.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/spec/spec_error.hpp"
#include "results/files/result_json.hpp"
#include "support/fixture.hpp"
#include "support/leaf_job.hpp"
#include "support/program.hpp"
#include "support/refusals.hpp"
#include "support/temporary_folder.hpp"
#include "tests/results/expected_json.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;
using nlohmann::json;
using test::unlike, test::unlike_text;
namespace fs = std::filesystem;
