#include <fmt/format.h>

#include <iterator>

#include "output.hpp"
#include "rivals/registry.hpp"
#include "subcommands.hpp"

namespace polhode::tools {

void add_methods(CLI::App& app) {
  CLI::App* command = app.add_subcommand("methods", "Every method: its order, what it conserves, where it fails");
  command->footer("Examples:\n  polhode methods");
  command->callback([] {
    fmt::memory_buffer text;
    for (const rivals::MeasuredMethod& m : rivals::measured_methods()) {
      fmt::format_to(std::back_inserter(text),
                     "{}\n  kind       {}\n  order      {}\n  conserves  {}\n  fails      {}\n  source     {}\n",
                     m.name, m.kind, m.order, m.conserves.text, m.fails, m.source);
    }
    for (const auto& [absent, library] : rivals::absent_methods()) {
      fmt::format_to(std::back_inserter(text), "{}\n  absent     this program was built without {}\n", absent, library);
    }
    write_standard_output({text.data(), text.size()});
  });
}

}  // namespace polhode::tools
