// SPDX-License-Identifier: Apache-2.0
// See module_writer.h.
#include "module_writer.h"

#include "inputs.h"

#include <map>

namespace conformance {

namespace {

constexpr size_t kFormsPerKernel = 32, kFormsPerModule = 160;

bool isWordCharacter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '.' || c == '%';
}

bool hasWord(const std::string& text, const std::string& word) {
    return findWord(text, word) != std::string::npos;
}

bool uses(const std::vector<Form>& forms, const std::vector<size_t>& numbers,
          const std::string& word) {
    for (const size_t number : numbers)
        if (hasWord(forms[number].code, word))
            return true;
    return false;
}

std::string registerType(const std::string& type) {
    const unsigned width = widthOf(type);
    return width == 1 ? ".pred" : ".b" + std::to_string(width < 16 ? 16 : width);
}

std::string text(size_t number) {
    return std::to_string(number);
}

// Loads operand `position` of the kernel's forms.
std::string loadInput(const std::string& type, unsigned position) {
    const std::string name = "a" + text(position);
    const std::string at = "[in+" + text(inputOffset(type, position)) + "];\n";
    const std::string declaration = ".reg " + registerType(type) + " " + name + ";\n";
    if (type == "p")
        return declaration + "ld.global.b32 word, " + at + "setp.ne.u32 " + name + ", word, 0;\n";
    return declaration + "ld.global.b" + text(widthOf(type)) + " " + name + ", " + at;
}

// The form in its own scope, and its results to memory.
std::string writeForm(const Form& form, size_t offset) {
    std::string body = "{ // " + form.name + "\n";
    const struct {
        const char *type, *name;
    } kFree[] = {{".b32", "t"}, {".b64", "u"}, {".b16", "h"}, {".pred", "q"}};
    for (const auto& kind : kFree)
        for (unsigned i = 0; i < 4; ++i)
            if (hasWord(form.code, kind.name + text(i))) {
                body += std::string(".reg ") + kind.type + " " + kind.name + "<4>;\n";
                break;
            }
    for (size_t i = 0; i < form.outputs.size(); ++i)
        body += ".reg " + registerType(form.outputs[i].type) + " d" + text(i) + ";\n";
    body += form.code + "\n";
    for (size_t i = 0; i < form.outputs.size(); ++i) {
        const std::string& type = form.outputs[i].type;
        const std::string bytes = text(bytesOf(type));
        std::string value = "d" + text(i);
        if (type == "p") {
            body += "selp.u32 word, 1, 0, " + value + ";\n";
            value = "word";
        }
        body += "st.global.b" + text(bytesOf(type) * 8) + " [out" + bytes + "+" + text(offset) +
                "], " + value + ";\n";
        offset += size_t(bytesOf(type)) * kVectors;
    }
    return body + "}\n";
}

std::string writeKernel(const std::vector<Form>& forms, const KernelText& kernel,
                        const std::map<size_t, size_t>& offsets) {
    std::string body =
        ".visible .entry " + kernel.name +
        "(.param .u64 p0, .param .u64 p1, .param .u64 p2) {\n"
        ".reg .b64 in, out1, out2, out4, out8, wide;\n.reg .b32 thread, word;\n"
        "ld.param.u64 in, [p0];\nld.param.u64 out1, [p1];\n"
        "mov.u32 thread, %ctaid.x;\nshl.b32 thread, thread, 5;\nmov.u32 word, %tid.x;\n"
        "add.u32 thread, thread, word;\ncvt.u64.u32 wide, thread;\n"
        "add.u64 out1, out1, wide;\nadd.u64 out2, out1, wide;\nadd.u64 out4, out2, wide;\n"
        "add.u64 out4, out4, wide;\nshl.b64 wide, wide, 3;\nadd.u64 in, in, wide;\n"
        "shr.u64 wide, wide, 1;\nadd.u64 out8, out4, wide;\n";
    if (uses(forms, kernel.forms, "m"))
        body +=
            ".reg .b64 m;\nld.param.u64 m, [p2];\nshl.b64 wide, wide, 4;\nadd.u64 m, m, wide;\n";
    if (uses(forms, kernel.forms, "sm"))
        body += ".reg .b64 sm;\nmov.u64 sm, shared;\nmul.wide.u32 wide, word, 64;\n"
                "add.u64 sm, sm, wide;\n";
    if (uses(forms, kernel.forms, "lm"))
        body += ".local .align 16 .b8 local[64];\n.reg .b64 lm;\nmov.u64 lm, local;\n";
    const std::vector<std::string>& inputs = forms[kernel.forms[0]].inputs;
    for (unsigned i = 0; i < inputs.size(); ++i)
        body += loadInput(inputs[i], i);
    for (const size_t number : kernel.forms)
        body += writeForm(forms[number], offsets.at(number));
    return body + "ret;\n}\n";
}

// Common to the forms of one kernel.
std::string kernelKey(const Form& form) {
    std::string key = form.warp ? "warp " : "";
    for (const std::string& input : form.inputs)
        key += input + " ";
    return key;
}

std::vector<std::vector<size_t>> splitByKernel(const std::vector<Form>& forms,
                                               const std::vector<size_t>& numbers) {
    std::map<std::string, std::vector<size_t>> open;
    std::vector<std::vector<size_t>> kernels;
    for (const size_t number : numbers) {
        auto& list = open[kernelKey(forms[number])];
        list.push_back(number);
        if (list.size() == kFormsPerKernel) {
            kernels.push_back(std::move(list));
            list.clear();
        }
    }
    for (auto& [key, list] : open)
        if (!list.empty())
            kernels.push_back(std::move(list));
    return kernels;
}

} // namespace

size_t findWord(const std::string& text, const std::string& word, size_t from) {
    for (size_t at = from; (at = text.find(word, at)) != std::string::npos; ++at)
        if ((at == 0 || !isWordCharacter(text[at - 1])) &&
            (at + word.size() >= text.size() || !isWordCharacter(text[at + word.size()])))
            return at;
    return std::string::npos;
}

unsigned bytesOf(const std::string& outputType) {
    return (widthOf(outputType) + 7) / 8;
}

size_t resultBytes(const Form& form) {
    size_t bytes = 0;
    for (const Output& output : form.outputs)
        bytes += size_t(bytesOf(output.type)) * kVectors;
    return bytes;
}

std::vector<std::vector<size_t>> splitForms(const std::vector<Form>& forms,
                                            const std::vector<size_t>& numbers) {
    std::vector<std::vector<size_t>> modules(1);
    for (const auto& kernel : splitByKernel(forms, numbers)) {
        if (modules.back().size() + kernel.size() > kFormsPerModule)
            modules.emplace_back();
        modules.back().insert(modules.back().end(), kernel.begin(), kernel.end());
    }
    if (modules.back().empty())
        modules.pop_back();
    return modules;
}

ModuleText writeModule(const std::vector<Form>& forms, const std::vector<size_t>& numbers) {
    ModuleText module;
    module.ptx = ".version 8.7\n.target sm_90\n.address_size 64\n";
    if (uses(forms, numbers, "sm") || uses(forms, numbers, "shared"))
        module.ptx += ".shared .align 64 .b8 shared[2048];\n";
    for (const auto& list : splitByKernel(forms, numbers)) {
        const KernelText kernel = {"k" + text(module.kernels.size()), list};
        std::map<size_t, size_t> offsets;
        for (const size_t number : list) {
            offsets[number] = module.bytes;
            module.offsets.push_back(module.bytes);
            module.bytes += resultBytes(forms[number]);
        }
        module.ptx += writeKernel(forms, kernel, offsets);
        module.kernels.push_back(kernel);
    }
    return module;
}

} // namespace conformance
