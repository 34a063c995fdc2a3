// SPDX-License-Identifier: Apache-2.0
// Forms that exchange data between threads: a block is one full warp.
#include "forms/forms.h"

namespace conformance {

namespace {

// Runs `code` in the odd lanes only.
std::string inOddLanes(const std::string& clear, const std::string& code) {
    return clear +
           " mov.u32 t0, %laneid; and.b32 t0, t0, 1; setp.eq.u32 q0, t0, 0; @q0 bra DONE; " + code +
           " DONE:";
}

void addVotes(Forms& forms) {
    forms.addWarp("vote.sync.{all|any|uni}.pred", {"p"}, {"p"}, "@ d0, a0, -1;");
    forms.addWarp(
        "vote.sync.{all|any|uni}.pred", {"p"}, {"p"},
        "mov.u32 t0, %ctaid.x; and.b32 t1, t0, 1; setp.eq.u32 q0, t1, 0; or.pred q0, q0, a0; "
        "and.b32 t1, t0, 2; setp.eq.u32 q1, t1, 0; and.pred q0, q0, q1; @ d0, q0, -1;",
        "some alike");
    forms.addWarp("vote.sync.ballot.b32", {"p"}, {"b32"}, "@ d0, a0, -1;");
    forms.addWarp("vote.sync.ballot.b32", {"p"}, {"b32"},
                  inOddLanes("mov.u32 d0, 0;", "@ d0, a0, 0xaaaaaaaa;"), "in odd lanes");
    forms.addWarp("match.any.sync.b32", {"i32"}, {"b32"}, "and.b32 t1, a0, 3; @ d0, t1, -1;");
    forms.addWarp("match.any.sync.b64", {"i64"}, {"b32"}, "and.b64 u1, a0, 3; @ d0, u1, -1;");
    forms.addWarp(
        "match.all.sync.b32", {"i32"}, {"b32", "p"},
        "mov.u32 t0, %ctaid.x; and.b32 t0, t0, 1; mul.lo.u32 t1, a0, t0; @ d0|d1, t1, -1;");
    forms.addWarp("match.all.sync.b64", {"i64"}, {"b32", "p"},
                  "mov.u32 t0, %ctaid.x; and.b32 t0, t0, 1; cvt.u64.u32 u0, t0; "
                  "mul.lo.u64 u1, a0, u0; @ d0|d1, u1, -1;");
    forms.addWarp("activemask.b32", {"i32"}, {"b32"}, "@ d0;");
    forms.addWarp("activemask.b32", {"i32"}, {"b32"}, inOddLanes("mov.u32 d0, 7;", "@ d0;"),
                  "in odd lanes");
    forms.addWarp("elect.sync", {"i32"}, {"b32", "p"}, "@ d0|d1, -1;");
}

void addShuffles(Forms& forms) {
    const struct {
        const char *mode, *clamp;
    } kModes[] = {{"up", "0"},        {"up", "0x1800"}, {"down", "31"},     {"down", "0x181f"},
                  {"down", "0x1f03"}, {"bfly", "31"},   {"bfly", "0x101f"}, {"idx", "31"},
                  {"idx", "0x181f"},  {"idx", "7"}};
    for (const auto& m : kModes) {
        const std::string name = std::string("shfl.sync.") + m.mode + ".b32";
        forms.addWarp(name, {"i32", "lane"}, {"b32", "p"},
                      std::string("@ d0|d1, a0, a1, ") + m.clamp + ", -1;",
                      std::string("lanes, ") + m.clamp);
        for (const char* distance : {"1", "5", "16"})
            forms.addWarp(name, {"i32"}, {"b32", "p"},
                          std::string("@ d0|d1, a0, ") + distance + ", " + m.clamp + ", -1;",
                          std::string(distance) + ", " + m.clamp);
    }
    forms.addWarp("shfl.sync.bfly.b32", {"i32"}, {"b32"},
                  inOddLanes("mov.u32 d0, 0;", "@ d0, a0, 2, 31, 0xaaaaaaaa;"), "in odd lanes");
    forms.addWarp("shfl.sync.idx.b32", {"i32"}, {"b32"},
                  inOddLanes("mov.u32 d0, 0;", "@ d0, a0, 5, 31, 0xaaaaaaaa;"), "in odd lanes");
}

void addReductions(Forms& forms) {
    forms.addWarp("redux.sync.{and|or|xor}.b32", {"i32"}, {"b32"}, "@ d0, a0, -1;");
    forms.addWarp("redux.sync.{add|min|max}.{u32|s32}", {"i32"}, {"b32"}, "@ d0, a0, -1;");
    forms.addWarp("redux.sync.{min|max}{|.abs}{|.NaN}.f32", {"f32"}, {"b32"}, "@ d0, a0, -1;");
    forms.addWarp("redux.sync.add.s32", {"i32"}, {"b32"},
                  inOddLanes("mov.u32 d0, 0;", "@ d0, a0, 0xaaaaaaaa;"), "in odd lanes");
    forms.addWarp("bar.red.popc.u32", {"p"}, {"b32"}, "@ d0, 0, a0;");
    forms.addWarp("barrier.red.popc.u32", {"p"}, {"b32"}, "@ d0, 0, 32, a0;");
    forms.addWarp("bar.red.{and|or}.pred", {"p"}, {"p"}, "@ d0, 0, a0;");
    forms.addWarp("bar.red.{and|or}.pred", {"p"}, {"p"}, "@ d0, 0, !a0;", "with not");
    // All threads at one place: the final contents do not depend on their order.
    for (const char* operation : {"add.u32", "min.s32", "max.u32", "and.b32", "or.b32", "xor.b32"})
        forms.addWarp(std::string("red.shared.") + operation, {"i32"}, {"b32"},
                      "mov.u64 u0, shared; st.shared.b32 [u0], 0x0f0f0f0f; bar.sync 0; "
                      "@ [u0], a0; bar.sync 0; ld.shared.b32 d0, [u0]; bar.sync 0;",
                      "of all threads");
    forms.addWarp("atom.shared.inc.u32", {"i32"}, {"b32"},
                  "mov.u64 u0, shared; st.shared.b32 [u0], 3; bar.sync 0; @ t0, [u0], 20; "
                  "bar.sync 0; ld.shared.b32 d0, [u0]; bar.sync 0;",
                  "of all threads");
}

} // namespace

void addWarpForms(Forms& forms) {
    addVotes(forms);
    addShuffles(forms);
    addReductions(forms);
    for (const char* name :
         {"%laneid", "%lanemask_eq", "%lanemask_lt", "%lanemask_le", "%lanemask_gt", "%lanemask_ge",
          "%tid.x", "%tid.y", "%ntid.x", "%ntid.z", "%ctaid.x", "%ctaid.y", "%nctaid.x",
          "%nctaid.y", "WARP_SZ"})
        forms.addWarp("mov.u32", {"i32"}, {"b32"}, std::string("@ d0, ") + name + ";", name);
}

} // namespace conformance
