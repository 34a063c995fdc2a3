// SPDX-License-Identifier: Apache-2.0
// Kernels that run forms: thread i of a launch computes vector i of every form of the kernel.
#pragma once

#include "forms/forms.h"

#include <string>
#include <vector>

namespace conformance {

// Bytes of one result of a type, as kernels store it.
unsigned bytesOf(const std::string& outputType);
// Bytes of all vectors of all outputs of a form.
size_t resultBytes(const Form& form);

struct KernelText {
    std::string name;
    std::vector<size_t> forms; // numbers in the list of all forms
};
struct ModuleText {
    std::string ptx;
    std::vector<KernelText> kernels;
    // Where the results of each form start in the module's output, in the order of the kernels.
    std::vector<size_t> offsets;
    size_t bytes = 0;
};

// Splits forms into lists, each for one module; forms of one kernel read the same inputs.
std::vector<std::vector<size_t>> splitForms(const std::vector<Form>& forms,
                                            const std::vector<size_t>& numbers);
ModuleText writeModule(const std::vector<Form>& forms, const std::vector<size_t>& numbers);

// Where `word`, a name of PTX, stands in `text`, or npos.
size_t findWord(const std::string& text, const std::string& word, size_t from = 0);

// Bytes of scratch memory per thread.
constexpr unsigned kScratch = 64;

} // namespace conformance
