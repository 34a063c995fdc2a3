// SPDX-License-Identifier: Apache-2.0
// Magic numbers of file formats that callers pass in place of PTX. See input_kind.h.
#include "ptx/input_kind.h"

namespace sunstone::ptx {
namespace {

bool startsWith(std::string_view bytes, std::string_view magic) {
    return bytes.substr(0, magic.size()) == magic;
}

} // namespace

std::string describeForeignInput(std::string_view bytes) {
    using namespace std::string_view_literals;
    if (bytes.empty() || bytes[0] == '\0')
        return "the PTX text is empty";
    if (startsWith(bytes, "\xED\x43\x4E\x7F"sv))
        return "this is OptiX-IR, a proprietary binary format: compile to PTX instead (nvcc -ptx "
               "in "
               "place of --optix-ir)";
    if (startsWith(bytes, "\x7F"
                          "ELF"sv))
        return "this is an ELF object (compiled device code, cubin): compile to PTX instead (nvcc "
               "-ptx)";
    if (startsWith(bytes, "BC\xC0\xDE"sv) || startsWith(bytes, "\xDE\xC0\x17\x0B"sv))
        return "this is LLVM bitcode: compile to PTX instead (nvcc -ptx, or clang "
               "--cuda-device-only -S)";
    if (startsWith(bytes, "\x50\xED\x55\xBA"sv) || startsWith(bytes, "\xB1\x43\x62\x46"sv))
        return "this is a CUDA fat binary: pass the PTX in it, or compile to PTX (nvcc -ptx)";
    if (startsWith(bytes, "\x1F\x8B"sv) || startsWith(bytes, "\x28\xB5\x2F\xFD"sv))
        return "this is compressed data, not PTX text";
    if (startsWith(bytes, "\xFF\xFE"sv) || startsWith(bytes, "\xFE\xFF"sv))
        return "this is UTF-16 text: PTX is ASCII";
    if (startsWith(bytes, "; ModuleID"sv) || startsWith(bytes, "target datalayout"sv))
        return "this is LLVM assembly: compile to PTX instead";
    return "";
}

} // namespace sunstone::ptx
