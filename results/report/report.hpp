#pragma once
// report.html: one file that needs nothing else, neither beside it nor from the network.
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "results/files/json_text.hpp"

namespace flexopt {

/// A file that was put into the binary at build time; empty if there is none of that name.
std::string_view embedded_file(std::string_view name);

// Pages out of templates.

/// The template with what `filling` gives for every name between two @. Its only @ are those.
std::string filled(std::string_view page,
                   const std::function<std::string(const std::string& name)>& filling);

/// Text escaped for use between tags of HTML.
std::string html_escaped(std::string_view text);

/// JSON inside a script element: there `<` may only occur in strings, where \u003c means the same;
/// so no "</script>" or "<!--" of a job's text ends the element.
std::string script_json(const OrderedJson& value);

/// An embedded file as it stands in a page.
std::string page_part(const std::string& name);

// report.html: one file that needs nothing else, neither beside it nor from the network.

/// The page that shows this result. `scene`: what it draws in three dimensions, of make_scene();
/// null where there is nothing to draw.
std::string make_report(const OrderedJson& result, const OrderedJson& scene);

void write_report(const std::filesystem::path& folder, const OrderedJson& result,
                  const OrderedJson& scene);

}  // namespace flexopt
