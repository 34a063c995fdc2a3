// SPDX-License-Identifier: Apache-2.0
// libFuzzer entry: for any bytes, the parser must return a tree or a message, and a printed tree
// must parse to the same tree.
#include "ptx/parse/parser.h"
#include "ptx/printer.h"

#include <cstdio>
#include <cstdlib>

using namespace sunstone::ptx;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    Diagnostics diagnostics;
    const auto module = parse(text, diagnostics);
    if ((module == nullptr) != diagnostics.failed())
        std::abort();
    if (!module) {
        if (diagnostics.format().empty())
            std::abort();
        return 0;
    }
    const std::string printed = print(*module);
    Diagnostics again;
    const auto copy = parse(printed, again);
    if (!copy || print(*copy) != printed) {
        std::fprintf(stderr, "does not survive printing:\n%s\n%s", printed.c_str(),
                     again.format().c_str());
        std::abort();
    }
    return 0;
}
