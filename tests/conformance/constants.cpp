// SPDX-License-Identifier: Apache-2.0
// See constants.h.
#include "constants.h"

#include "compare.h"
#include "forms/run_forms.h"
#include "inputs.h"
#include "module_writer.h"

#include <algorithm>
#include <cstdio>

namespace conformance {

namespace {

// Random numbers of one form.
class Chance {
public:
    explicit Chance(uint64_t seed) : state_(scramble(seed)) {}
    uint64_t below(uint64_t limit) { return (state_ = scramble(state_)) % limit; }

private:
    uint64_t state_;
};

std::string replaceWord(std::string text, const std::string& word, const std::string& with) {
    for (size_t at = 0; (at = findWord(text, word, at)) != std::string::npos; at += with.size())
        text.replace(at, word.size(), with);
    return text;
}

// Code before the form that puts the input of vector `vector` at `position` into register `name`.
std::string operandCode(const Form& form, unsigned position, unsigned vector,
                        const std::string& name, bool constant) {
    const std::string& type = form.inputs[position];
    const unsigned width = widthOf(type);
    const uint64_t bits = inputBits(type, position, vector);
    const std::string at = std::to_string(inputOffset(type, position) + vector * 8);
    if (width == 1)
        return ".reg .pred " + name + ";\n" +
               (constant ? "setp.ne.u32 " + name + ", " + std::to_string(uint32_t(bits)) + ", 0;\n"
                         : "ld.global.b32 word, [same+" + at + "];\nsetp.ne.u32 " + name +
                               ", word, 0;\n");
    const std::string suffix = ".b" + std::to_string(width) + " ";
    const uint64_t mask = width == 64 ? ~0ull : (1ull << width) - 1;
    return ".reg" + (" " + suffix) + name + ";\n" +
           (constant ? "mov" + suffix + name + ", " + std::to_string(bits & mask) + ";\n"
                     : "ld.global" + suffix + name + ", [same+" + at + "];\n");
}

// The form with the operands in `positions` from one vector for all threads.
Form withOperands(const Form& form, const std::vector<unsigned>& positions, unsigned vector,
                  bool constant) {
    Form made = form;
    std::string before = constant ? "" : ".reg .b64 same;\nld.param.u64 same, [p0];\n";
    for (const unsigned position : positions) {
        const std::string name = "same" + std::to_string(position);
        made.code = replaceWord(made.code, "a" + std::to_string(position), name);
        before += operandCode(form, position, vector, name, constant);
    }
    made.code = before + made.code;
    made.name += (constant ? " constant" : " loaded") + (" vector " + std::to_string(vector));
    for (Output& output : made.outputs)
        if (output.rule.kind != Rule::kExact)
            output.rule = number();
    return made;
}

// Pairs of forms: constant operands, the same ones loaded.
std::vector<Form> makePairs(uint64_t seed, size_t count, const std::string& only) {
    std::vector<Form> forms = allForms(), pairs;
    std::erase_if(forms, [&](const Form& form) {
        return form.inputs.empty() || form.name.find(only) == std::string::npos;
    });
    Chance chance(seed);
    for (size_t i = 0; i < std::min(count, forms.size()); ++i) {
        std::swap(forms[i], forms[i + chance.below(forms.size() - i)]);
        const Form& form = forms[i];
        std::vector<unsigned> positions;
        const uint64_t chosen = 1 + chance.below((1u << form.inputs.size()) - 1);
        for (unsigned position = 0; position < form.inputs.size(); ++position)
            if (chosen >> position & 1)
                positions.push_back(position);
        const auto vector = unsigned(chance.below(kVectors));
        for (const bool constant : {true, false})
            pairs.push_back(withOperands(form, positions, vector, constant));
    }
    return pairs;
}

} // namespace

bool checkConstants(uint64_t seed, size_t count, const std::string& only) {
    const std::vector<Form> forms = makePairs(seed, count, only);
    std::vector<size_t> numbers;
    for (size_t i = 0; i < forms.size(); ++i)
        numbers.push_back(i);
    const Results results = runForms(forms, numbers, 0);
    unsigned different = 0, refused = 0;
    for (size_t i = 0; i < forms.size(); i += 2) {
        const Status constant = results.status[i], loaded = results.status[i + 1];
        if (constant == Status::kRefused && loaded == Status::kRefused) {
            ++refused;
            continue;
        }
        std::string fault;
        if (constant != Status::kDone)
            fault = "  the form with constants does not run\n";
        if (loaded != Status::kDone)
            fault += "  the form with loaded operands does not run\n";
        if (fault.empty())
            fault = compare(forms[i], results.results[i + 1], results.results[i]).text;
        if (fault.empty())
            continue;
        ++different;
        std::printf("%s:\n%s", forms[i].name.c_str(), fault.c_str());
    }
    std::printf("--seed %llu: %zu forms with constant operands on %s, %u differ from loaded ones, "
                "%u refused\n",
                static_cast<unsigned long long>(seed), forms.size() / 2, results.device.c_str(),
                different, refused);
    return different == 0;
}

} // namespace conformance
