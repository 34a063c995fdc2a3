// SPDX-License-Identifier: Apache-2.0
#include "api/optixu/options.h"

#include <algorithm>

namespace sunstone::optixu {
namespace {

enum class Value { kNone, kJoined, kJoinedOrNext }; // kJoined: -name=value

struct Rule {
    const char* name; // without dashes
    const char* shortName;
    Value value;
    std::vector<std::string> clang;
};

const std::vector<Rule>& rules() {
    static const auto& table = *new std::vector<Rule>{
        {"use_fast_math",
         "use_fast_math",
         Value::kNone,
         {"-fcuda-flush-denormals-to-zero", "-fgpu-approx-transcendentals", "-mllvm",
          "-nvptx-prec-divf32=0", "-mllvm", "-nvptx-prec-sqrtf32=0"}},
        {"generate-line-info", "lineinfo", Value::kNone, {"-gline-directives-only"}},
        {"device-debug", "G", Value::kNone, {"-g"}},
        {"debug", "g", Value::kNone, {}}, // of host code
        // The PTX has the library's target, which every device runs.
        {"gpu-architecture", "arch", Value::kJoinedOrNext, {}},
        {"gpu-code", "code", Value::kJoinedOrNext, {}},
        {"generate-code", "gencode", Value::kJoinedOrNext, {}},
        {"relocatable-device-code", "rdc", Value::kJoinedOrNext, {}},
        {"machine", "m", Value::kJoinedOrNext, {}},
        {"m64", "m64", Value::kNone, {}},
        {"ptx", "ptx", Value::kNone, {}},
        {"device-c", "dc", Value::kNone, {}},
        {"maxrregcount", "maxrregcount", Value::kJoinedOrNext, {}},
        {"ptxas-options", "Xptxas", Value::kJoinedOrNext, {}},
        {"compiler-options", "Xcompiler", Value::kJoinedOrNext, {}},
        {"compiler-bindir", "ccbin", Value::kJoinedOrNext, {}},
        {"fmad", "fmad", Value::kJoined, {}},
        {"restrict", "restrict", Value::kNone, {}},
        // The headers are C++17; older code is mostly valid in it.
        {"std=c++03", "std=c++03", Value::kNone, {}},
        {"std=c++11", "std=c++11", Value::kNone, {}},
        {"std=c++14", "std=c++14", Value::kNone, {}},
    };
    return table;
}

} // namespace

std::vector<std::string> clangOptions(const std::vector<std::string>& nvccOptions) {
    std::vector<std::string> options;
    for (size_t i = 0; i < nvccOptions.size(); ++i) {
        const std::string& option = nvccOptions[i];
        const size_t dashes = std::min(option.find_first_not_of('-'), size_t(2));
        const size_t equals = option.find('=');
        const auto isIt = [&](const Rule& rule) {
            const std::string name = option.substr(std::min(dashes, option.size()));
            const std::string word = name.substr(0, name.find('='));
            if (rule.value == Value::kNone)
                return name == rule.name || name == rule.shortName;
            return (word == rule.name || word == rule.shortName) &&
                   (equals != std::string::npos || rule.value == Value::kJoinedOrNext);
        };
        const auto rule =
            dashes == 0 ? rules().end() : std::find_if(rules().begin(), rules().end(), isIt);
        if (rule == rules().end()) {
            options.push_back(option);
            continue;
        }
        options.insert(options.end(), rule->clang.begin(), rule->clang.end());
        if (rule->value == Value::kJoinedOrNext && equals == std::string::npos)
            ++i; // the value
    }
    return options;
}

} // namespace sunstone::optixu
