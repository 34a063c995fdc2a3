// SPDX-License-Identifier: Apache-2.0
// Takes the PTX of kernels.cu (SUNSTONE_BUILDER_PTX, a file of the build) into the library.
#include "bvh/gpu/kernels_ptx.h"

#include "base/error.h"

#include <algorithm>

asm(".pushsection .rodata\n"
    "sunstone_builder_ptx:\n"
    ".incbin \"" SUNSTONE_BUILDER_PTX "\"\n"
    ".byte 0\n"
    ".popsection\n");
extern "C" __attribute__((visibility("hidden"))) const char sunstone_builder_ptx[];

namespace sunstone::bvh::gpu {

namespace {

// A kernel, a definition or declaration of a function, or what is between these.
struct Piece {
    std::string_view text, name; // of a kernel or function
    bool isWanted = false;
};

bool isNamePart(char c) {
    return c == '_' || c == '$' || (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') ||
           (c >= 'A' && c <= 'Z');
}

// The name is what stands before the parameters; a function's results come first.
std::string_view nameIn(std::string_view head) {
    if (const size_t results = head.find(".func"); results != head.npos) {
        head.remove_prefix(results + 5);
        const size_t start = head.find_first_not_of(" \t\n");
        if (start != head.npos && head[start] == '(')
            head.remove_prefix(head.find(')') + 1);
    } else {
        head.remove_prefix(head.find(".entry") + 6);
    }
    const size_t first = size_t(std::find_if(head.begin(), head.end(), isNamePart) - head.begin());
    head.remove_prefix(first);
    return head.substr(0, size_t(std::find_if_not(head.begin(), head.end(), isNamePart) -
                                 head.begin()));
}

std::vector<Piece> piecesOf(std::string_view ptx) {
    std::vector<Piece> pieces;
    size_t begin = 0, at = 0;
    while (at < ptx.size()) {
        const std::string_view line = ptx.substr(at, ptx.find('\n', at) - at);
        const bool isStart = line.starts_with('.') && (line.find(".entry") != line.npos ||
                                                       line.find(".func") != line.npos);
        const size_t body = isStart ? ptx.find_first_of("{;", at) : ptx.npos;
        if (body == ptx.npos) {
            at += line.size() + 1;
            continue;
        }
        // A body ends with a brace in the first column.
        const size_t brace = ptx[body] == ';' ? body - 1 : ptx.find("\n}", body);
        const size_t end = brace == ptx.npos ? ptx.size() : brace + 2;
        pieces.push_back({ptx.substr(begin, at - begin), {}, true});
        pieces.push_back({ptx.substr(at, end - at), nameIn(ptx.substr(at, body - at))});
        begin = at = end;
    }
    pieces.push_back({ptx.substr(begin), {}, true});
    return pieces;
}

} // namespace

const char* builderPtx() {
    return sunstone_builder_ptx;
}

std::string moduleOf(std::string_view ptx, const std::vector<std::string_view>& kernels) {
    std::vector<Piece> pieces = piecesOf(ptx);
    std::vector<std::string_view> unread;
    const auto want = [&](Piece& piece) {
        if (piece.isWanted)
            return;
        piece.isWanted = true;
        unread.push_back(piece.text);
    };
    for (const std::string_view kernel : kernels) {
        const auto found = std::find_if(pieces.begin(), pieces.end(),
                                        [&](const Piece& p) { return p.name == kernel; });
        if (found == pieces.end())
            fail(Code::kInternal, "there is no kernel ", kernel);
        want(*found);
    }
    while (!unread.empty()) {
        const std::string_view text = unread.back();
        unread.pop_back();
        for (Piece& piece : pieces)
            if (!piece.isWanted && text.find(piece.name) != text.npos)
                want(piece);
    }
    std::string result;
    for (const Piece& piece : pieces)
        if (piece.isWanted)
            result += piece.text;
    return result;
}

} // namespace sunstone::bvh::gpu
