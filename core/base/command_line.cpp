// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/command_line.h"

#include <fmt/format.h>

#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "base/messages.h"
#include "base/near_miss.h"
#include "base/say.h"

namespace openfab {

namespace {

std::vector<std::string> option_names(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options()) {
        for (const std::string& name : option->get_lnames())
            names.push_back("--" + name);
    }
    return names;
}

Error wrong_usage(std::string what, std::string help) {
    return {ErrorCode::kUsage, std::move(what), std::move(help), {}};
}

Error unknown(const std::string& what, const std::string& name,
              const std::vector<std::string>& known, const std::string& program) {
    const std::string near = near_miss(name, known);
    return wrong_usage(fmt::format(messages::kNoSuchArgument, what, name),
                       near.empty() ? fmt::format(messages::kHelpLists, program, what + "s")
                                    : fmt::format(messages::kDidYouMean, near));
}

}  // namespace

Error command_line_error(const CLI::App& app, const CLI::ParseError& error,
                         const std::string& program) {
    const std::vector<CLI::App*> chosen = app.get_subcommands();
    const CLI::App& command = chosen.empty() ? app : *chosen.back();
    const std::string full =
        chosen.empty() ? program : fmt::format("{} {}", program, command.get_name());
    const std::vector<const CLI::App*> commands =
        app.get_subcommands([](const CLI::App*) { return true; });
    // Only the first unknown word is reported: after a wrong command all that follows is unknown,
    // too. A command that hands words on does not know which of them are options.
    const std::vector<std::string> words =
        command.get_allow_extras() ? std::vector<std::string>() : app.remaining(true);
    for (const std::string& word : words) {
        if (word.starts_with('-'))
            return unknown("option", word.substr(0, word.find('=')), option_names(command), full);
        if (!chosen.empty() || commands.empty()) continue;
        std::vector<std::string> names;
        for (const CLI::App* other : commands)
            names.push_back(other->get_name());
        return unknown("command", word, names, program);
    }
    const std::string what = error.what();
    const size_t colon = what.find(": ");
    if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError) &&
        colon != std::string::npos) {
        return wrong_usage(fmt::format(messages::kTooManyArguments, what.substr(colon + 2)),
                           fmt::format(messages::kHelpLists, full, "arguments"));
    }
    return wrong_usage(what,
                       fmt::format(messages::kHelpLists, full,
                                   chosen.empty() && !commands.empty() ? "commands" : "options"));
}

void add_examples(CLI::App* app, const std::string& examples) {
    for (CLI::App* command : app->get_subcommands([](const CLI::App*) { return true; })) {
        const std::string call = fmt::format("  {} {} ", app->get_name(), command->get_name());
        std::string own;
        std::istringstream lines(examples);
        for (std::string line; std::getline(lines, line);)
            own += (line + ' ').starts_with(call) ? line + '\n' : "";
        if (!own.empty() && command->get_footer().empty()) command->footer("Examples:\n" + own);
    }
    app->footer("Examples:\n" + examples);
}

int run_command_line(CLI::App* app, int argc, const char* const* argv, const std::string& program,
                     const std::function<Result<void>()>& run) {
    Result<void> done;
    try {
        if (argc == 1 && app->get_require_subcommand_min() > 0) {
            show(app->help());  // who gives no command wants to know them
        } else {
            app->parse(argc, argv);
            done = run();
        }
    } catch (const CLI::CallForHelp&) {
        show(app->help());
    } catch (const CLI::CallForAllHelp&) {
        show(app->help("", CLI::AppFormatMode::All));
    } catch (const CLI::CallForVersion& version) {
        show(std::string(version.what()) + "\n");
    } catch (const CLI::ParseError& error) {
        done = command_line_error(*app, error, program);
    }
    if (done) done = written_out();
    if (done) return 0;
    return say_error(done.error());
}

}  // namespace openfab
