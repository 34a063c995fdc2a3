// SPDX-License-Identifier: Apache-2.0
// See forms.h.
#include "forms/forms.h"

#include <cstdio>
#include <cstdlib>
#include <set>

namespace conformance {

namespace {

// All readings of a pattern with {a|b|}.
std::vector<std::string> expand(const std::string& pattern) {
    const size_t open = pattern.find('{');
    if (open == std::string::npos)
        return {pattern};
    const size_t close = pattern.find('}', open);
    const std::string before = pattern.substr(0, open);
    const std::vector<std::string> rest = expand(pattern.substr(close + 1));
    std::vector<std::string> all;
    for (size_t start = open + 1; start <= close;) {
        const size_t end = std::min(pattern.find('|', start), close);
        for (const std::string& tail : rest)
            all.push_back(before + pattern.substr(start, end - start) + tail);
        start = end + 1;
    }
    return all;
}

std::string plainCode(size_t inputs) {
    std::string code = "@ d0";
    for (size_t i = 0; i < inputs; ++i)
        code += ", a" + std::to_string(i);
    return code + ";";
}

} // namespace

void Forms::add(const std::string& pattern, const std::vector<std::string>& inputs,
                const std::vector<Output>& outputs, const std::string& code,
                const std::string& note) {
    for (const std::string& instruction : expand(pattern)) {
        Form form;
        form.name = instruction + (note.empty() ? "" : " " + note);
        form.code = code.empty() ? plainCode(inputs.size()) : code;
        for (size_t at = 0; (at = form.code.find("@ ", at)) != std::string::npos;)
            form.code.replace(at, 1, instruction);
        form.inputs = inputs;
        form.outputs = outputs;
        list.push_back(std::move(form));
    }
}

void Forms::addWarp(const std::string& pattern, const std::vector<std::string>& inputs,
                    const std::vector<Output>& outputs, const std::string& code,
                    const std::string& note) {
    const size_t first = list.size();
    add(pattern, inputs, outputs, code, note);
    for (size_t i = first; i < list.size(); ++i)
        list[i].warp = true;
}

unsigned widthOf(const std::string& type) {
    if (type == "p")
        return 1;
    if (type == "b8")
        return 8;
    if (type == "i16" || type == "b16" || type == "f16" || type == "bf16")
        return 16;
    if (type == "i64" || type == "b64" || type == "f64")
        return 64;
    return 32;
}

std::vector<Form> allForms() {
    Forms forms;
    addIntegerForms(forms);
    addBitForms(forms);
    addFloatForms(forms);
    addComparisonForms(forms);
    addConversionForms(forms);
    addMemoryForms(forms);
    addWarpForms(forms);
    addVideoForms(forms);
    std::set<std::string> names;
    for (const Form& form : forms.list)
        if (!names.insert(form.name).second) {
            std::fprintf(stderr, "two forms are called \"%s\"\n", form.name.c_str());
            std::exit(2);
        }
    return std::move(forms.list);
}

} // namespace conformance
