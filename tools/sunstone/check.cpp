// SPDX-License-Identifier: Apache-2.0
// `sunstone check`: parses and verifies a PTX file, checks its OptiX calls, and prints faults with
// their places.
#include "commands.h"

#include "base/error.h"
#include "compiler/optix7/inspect.h"
#include "model/model.h"
#include "ptx/parse/parser.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <set>

namespace sunstone::tool {
namespace {

using Json = nlohmann::ordered_json;

struct Fault {
    std::string severity;
    ptx::Location location;
    std::string text;
};

const char* severityName(ptx::Severity severity) {
    switch (severity) {
    case ptx::Severity::kError:
        return "error";
    case ptx::Severity::kWarning:
        return "warning";
    case ptx::Severity::kNote:
        break;
    }
    return "note";
}

// Splits "line 12:5: text" (column optional), the form in which the compiler names places.
Fault splitPlace(const std::string& message) {
    Fault fault = {"error", {}, message};
    unsigned line = 0, column = 0;
    int used = 0;
    if (std::sscanf(message.c_str(), "line %u:%u: %n", &line, &column, &used) == 2 && used > 0) {
        fault.location = {line, column};
        fault.text = message.substr(size_t(used));
    } else if (std::sscanf(message.c_str(), "line %u: %n", &line, &used) == 1 && used > 0) {
        fault.location = {line, 0};
        fault.text = message.substr(size_t(used));
    }
    return fault;
}

std::string lineOf(const std::string& text, uint32_t line) {
    size_t start = 0;
    for (uint32_t i = 1; i < line && start != std::string::npos; ++i) {
        start = text.find('\n', start);
        start = start == std::string::npos ? start : start + 1;
    }
    if (line == 0 || start == std::string::npos)
        return "";
    std::string found = text.substr(start, text.find('\n', start) - start);
    for (char& c : found)
        if (uint8_t(c) < 32 || c == 127)
            c = ' '; // also keeps the caret in place under tabs
    return found;
}

void print(const Fault& fault, const CheckOptions& options, const std::string& text) {
    std::string place = options.file;
    if (fault.location.line != 0)
        place += ":" + std::to_string(fault.location.line);
    if (fault.location.column != 0)
        place += ":" + std::to_string(fault.location.column);
    std::fprintf(stderr, "%s: %s: %s\n", place.c_str(), fault.severity.c_str(), fault.text.c_str());
    std::string line = lineOf(text, fault.location.line);
    constexpr size_t kLongest = 160; // lines of a generated one-line module are of no use
    if (line.empty() || line.size() > kLongest)
        return;
    std::fprintf(stderr, "    %s\n", line.c_str());
    if (fault.location.column != 0 && fault.location.column <= line.size() + 1)
        std::fprintf(stderr, "    %*s\n", int(fault.location.column), "^");
}

struct Result {
    std::vector<Fault> faults;
    std::unique_ptr<ptx::Module> module;
    compiler::ModuleSummary summary;
    bool ok = false;
};

bool hasVariable(const ptx::Module& module, const std::string& name) {
    return std::any_of(module.variables.begin(), module.variables.end(),
                       [&](const ptx::Variable& variable) { return variable.name == name; });
}

Result examine(const std::string& text, const CheckOptions& options) {
    Result result;
    ptx::Diagnostics diagnostics;
    result.module = ptx::parse(text, diagnostics);
    for (const ptx::Diagnostic& d : diagnostics.all())
        result.faults.push_back({severityName(d.severity), d.location, d.text});
    if (!result.module)
        return result;
    // The most permissive rules: only code that every pipeline rejects is a fault.
    compiler::PipelineRules rules;
    rules.launchParams = options.launchParams;
    compiler::ModuleRules moduleRules;
    moduleRules.payloadTypes = compiler::widestPayloadTypes(*result.module);
    rules.optix7.numPayloadValues = moduleRules.payloadTypes.empty() ? 32 : 0;
    rules.optix7.numAttributeValues = 8;
    try {
        result.summary = compiler::inspect(*result.module, rules, moduleRules);
        result.ok = true;
        if (options.launchParams != CheckOptions().launchParams &&
            !hasVariable(*result.module, options.launchParams))
            result.faults.push_back(
                {"warning", {}, message("there is no variable \"", options.launchParams, "\"")});
        for (const ptx::Function* function : compiler::undefinedFunctions(*result.module))
            result.faults.push_back(
                {"warning", function->location,
                 message("function \"", function->name,
                         "\" is declared, but not defined here: another module of the program "
                         "must define it")});
    } catch (const Error& error) {
        result.faults.push_back(splitPlace(error.what()));
    }
    return result;
}

// Entries that are not OptiX programs.
std::vector<std::string> kernelsOf(const Result& result) {
    std::set<std::string> programs;
    for (const auto& program : result.summary.programs)
        if (program.kind != compiler::ProgramKind::kNone)
            programs.insert(program.name);
    std::vector<std::string> kernels;
    for (const ptx::Function& function : result.module->functions)
        if (function.isEntry && function.hasBody && !programs.count(std::string(function.name)))
            kernels.emplace_back(function.name);
    return kernels;
}

void printJson(const Result& result, const CheckOptions& options) {
    Json out;
    out["file"] = options.file;
    out["ok"] = result.ok;
    out["diagnostics"] = Json::array();
    for (const Fault& fault : result.faults)
        out["diagnostics"].push_back({{"severity", fault.severity},
                                      {"line", fault.location.line},
                                      {"column", fault.location.column},
                                      {"text", fault.text}});
    out["programs"] = Json::array();
    out["kernels"] = Json::array();
    if (result.ok) {
        for (const auto& program : result.summary.programs)
            if (program.kind != compiler::ProgramKind::kNone)
                out["programs"].push_back({{"name", program.name},
                                           {"payload", program.payloadWords},
                                           {"traces", program.traces}});
        out["kernels"] = kernelsOf(result);
        out["launchParamsSize"] = result.summary.launchParamsSize;
    }
    // Names and messages quote the file, which may contain any bytes.
    std::printf("%s\n", out.dump(2, ' ', true, Json::error_handler_t::replace).c_str());
}

void printSummary(const Result& result, const CheckOptions& options) {
    std::printf("%s: ok, PTX %u.%u\n", options.file.c_str(), result.module->versionMajor,
                result.module->versionMinor);
    for (const auto& program : result.summary.programs)
        if (program.kind != compiler::ProgramKind::kNone)
            std::printf("  program %s%s\n", program.name.c_str(),
                        program.traces ? " (traces rays)" : "");
    for (const std::string& kernel : kernelsOf(result))
        std::printf("  kernel  %s\n", kernel.c_str());
    if (result.summary.launchParamsSize != 0)
        std::printf("  launch parameters \"%s\": %llu bytes\n", options.launchParams.c_str(),
                    static_cast<unsigned long long>(result.summary.launchParamsSize));
}

} // namespace

int check(const CheckOptions& options) {
    std::string text;
    try {
        text = model::readFile(options.file);
    } catch (const model::ModelError& error) {
        throw std::runtime_error(options.file + ": " + error.what());
    }
    Result result = examine(text, options);
    if (options.json) {
        printJson(result, options);
        return result.ok ? 0 : 1;
    }
    for (const Fault& fault : result.faults)
        print(fault, options, text);
    if (!result.ok)
        return 1;
    printSummary(result, options);
    return 0;
}

} // namespace sunstone::tool
