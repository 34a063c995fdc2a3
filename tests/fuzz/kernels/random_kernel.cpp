// SPDX-License-Identifier: Apache-2.0
#include "random_kernel.h"

#include <iterator>

namespace fuzz {

namespace {

// The registers: %v differ from thread to thread, %s begin alike, %k are the same in all threads
// that have not ended.
constexpr unsigned kVarying = 6, kAlike = 3, kCommon = 2;

std::string name(const char* kind, size_t i) {
    return kind + std::to_string(i);
}

constexpr const char* kFunctions = R"(
.func (.reg .b32 %result) rounds(.reg .b32 %a, .reg .b32 %b)
{
    .reg .b32 %i, %t, %end;
    .reg .pred %p;
    and.b32 %end, %b, 7;
    mov.u32 %i, 0;
    mov.u32 %result, %a;
A:
    setp.ge.u32 %p, %i, %end;
    @%p bra B;
    mad.lo.u32 %result, %result, 5, %i;
    add.u32 %i, %i, 1;
    and.b32 %t, %result, 31;
    setp.ne.u32 %p, %t, 3;
    @%p bra A;
    mov.u32 %result, 9;
B:
    ret;
}
.func (.reg .b32 %result) deep(.reg .b32 %a, .reg .b32 %b)
{
    .reg .b32 %t, %u;
    .reg .pred %p;
    and.b32 %u, %b, 3;
    mov.u32 %result, %a;
    setp.eq.u32 %p, %u, 0;
    @%p bra A;
    sub.u32 %u, %u, 1;
    mul.lo.u32 %t, %a, 3;
    call (%result), deep, (%t, %u);
    shr.u32 %result, %result, 1;
    add.u32 %result, %result, %u;
A:
    ret;
}
)";

} // namespace

std::string RandomKernel::varying() {
    const size_t kind = below(12);
    if (kind == 0)
        return number(200);
    if (kind == 1)
        return name("%k", below(kCommon));
    if (kind < 4)
        return name("%s", below(kAlike));
    if (kind == 4 && !counters_.empty())
        return counters_[below(counters_.size())];
    return name("%v", below(kVarying));
}

std::string RandomKernel::target() {
    return chance(75) ? name("%v", below(kVarying)) : name("%s", below(kAlike));
}

std::string RandomKernel::counter() {
    if (!counters_.empty() && chance(70))
        return counters_[below(counters_.size())];
    return chance(50) ? name("%k", below(kCommon)) : name("%s", below(kAlike));
}

std::string RandomKernel::condition() {
    static constexpr const char* kCompare[] = {"eq", "ne", "lt", "le", "gt", "ge"};
    const std::string predicate = fresh("%p"), part = fresh("%t");
    const std::string compare = std::string("setp.") + kCompare[below(6)] + ".u32 " + predicate;
    if (chance(25)) {
        line(compare + ", " + counter() + ", " + number(5));
        return predicate;
    }
    const bool isOfLatest = !latest_.empty() && chance(40);
    line("and.b32 " + part + ", " + (isOfLatest ? latest_ : varying()) + ", " +
         std::to_string((1u << (1 + below(5))) - 1));
    if (isOfLatest && chance(60)) {
        const std::string own = fresh("%t");
        line("and.b32 " + own + ", " + name("%v", below(kVarying)) + ", 15");
        line(compare + ", " + part + ", " + own);
    } else {
        line(compare + ", " + part + ", " + (chance(30) ? counter() : number(8)));
    }
    return predicate;
}

// The address of one of the words at `base`.
std::string RandomKernel::address(const std::string& index, const std::string& base,
                                  unsigned words) {
    const std::string place = fresh("%t"), result = fresh("%d");
    line("and.b32 " + place + ", " + index + ", " + std::to_string(words - 1));
    if (chance(70)) {
        line("mad.wide.u32 " + result + ", " + place + ", 4, " + base);
    } else {
        line("cvt.s64.s32 " + result + ", " + place);
        line("shl.b64 " + result + ", " + result + ", 2");
        line("add.s64 " + result + ", " + base + ", " + result);
    }
    return result;
}

// ---- statements of one thread -----------------------------------------------------------------

void RandomKernel::compute() {
    static constexpr const char* kBinary[] = {"add.u32", "sub.u32", "mul.lo.u32", "xor.b32",
                                              "and.b32", "or.b32",  "min.u32",    "max.s32",
                                              "shr.u32", "shl.b32", "mul.hi.u32"};
    const std::string into = target();
    switch (below(8)) {
    case 0:
        line("mov.u32 " + into + ", " + (chance(50) ? number(100) : counter()));
        return;
    case 1:
        line("mad.lo.u32 " + into + ", " + varying() + ", " + varying() + ", " + varying());
        return;
    case 2: {
        const std::string divisor = fresh("%t");
        line("or.b32 " + divisor + ", " + varying() + ", 1");
        line((chance(50) ? "div.u32 " : "rem.s32 ") + into + ", " + varying() + ", " + divisor);
        return;
    }
    case 3: {
        const std::string choice = condition();
        line("selp.b32 " + into + ", " + varying() + ", " + varying() + ", " + choice);
        return;
    }
    default:
        line(std::string(kBinary[below(std::size(kBinary))]) + " " + into + ", " + varying() +
             ", " + varying());
    }
}

void RandomKernel::computeReal() {
    const std::string first = fresh("%f"), second = fresh("%f");
    line("cvt.rn.f32.u32 " + first + ", " + name("%v", below(kVarying)));
    line("cvt.rn.f32.s32 " + second + ", " + name("%s", below(kAlike)));
    line("fma.rn.f32 " + first + ", " + first + ", 0f3F000003, " + second);
    line("min.f32 " + first + ", " + first + ", 0f4E000000");
    line("cvt.rzi.s32.f32 " + target() + ", " + first);
}

void RandomKernel::computeLong() {
    const std::string wide = fresh("%d");
    line("mul.wide.s32 " + wide + ", " + varying() + ", " + varying());
    line("add.s64 " + wide + ", " + wide + ", 77777777777");
    line("shr.u64 " + wide + ", " + wide + ", " + number(33));
    line("cvt.u32.u64 " + target() + ", " + wide);
}

// From constant memory: all threads at one place, side by side, or anywhere.
void RandomKernel::read() {
    std::string index;
    switch (below(3)) {
    case 0:
        index = counter();
        break;
    case 1:
        index = fresh("%t");
        line("mad.lo.u32 " + index + ", " + counter() + ", " + (chance(50) ? "32" : "%all") +
             ", %me");
        break;
    default:
        index = varying();
    }
    const std::string from = address(index, "%in", kInputWords);
    static constexpr const char* kLoads[] = {"global.u32", "global.u32", "global.u32",
                                             "global.u8",  "global.s16", "volatile.global.u32"};
    line(std::string("ld.") + kLoads[below(std::size(kLoads))] + " " + target() + ", [" + from +
         "]");
}

void RandomKernel::readAlike() {
    const std::string index = fresh("%t");
    line("mad.lo.u32 " + index + ", " + counter() + ", " + std::to_string(1 + below(5)) + ", " +
         number(50));
    const std::string from = address(index, "%in", kInputWords);
    latest_ = target();
    line("ld.global.u32 " + latest_ + ", [" + from + "]");
}

void RandomKernel::ownMemory() {
    const std::string place = address(chance(50) ? varying() : counter(), "%local", 8);
    if (chance(50))
        line("st.local.u32 [" + place + "], " + varying());
    else
        line("ld.local.u32 " + target() + ", [" + place + "]");
}

// The thread has a word in each of several rows, and a word of shared memory.
void RandomKernel::ownWords() {
    if (chance(30)) {
        line("atom.shared.add.u32 " + target() + ", [%slot], " + varying());
        return;
    }
    const std::string row = fresh("%t");
    line("and.b32 " + row + ", " + (chance(60) ? counter() : varying()) + ", 3");
    line("mad.lo.u32 " + row + ", " + row + ", %total, %me");
    const std::string place = fresh("%d");
    line("mad.wide.u32 " + place + ", " + row + ", 4, %planes");
    if (chance(50))
        line("st.global.u32 [" + place + "], " + varying());
    else
        line("ld.global.u32 " + target() + ", [" + place + "]");
}

void RandomKernel::sum() {
    static constexpr const char* kSum[] = {"add.u32", "max.u32", "xor.b32", "or.b32"};
    const size_t which = below(kSums);
    line(std::string("red.global.") + kSum[which % 4] + " [%sums+" + std::to_string(which * 4) +
         "], " + varying());
}

void RandomKernel::call() {
    line("call (" + target() + "), " + (chance(60) ? "rounds" : "deep") + ", (" +
         name("%v", below(kVarying)) + ", " + name("%s", below(kAlike)) + ")");
}

// ---- statements of several threads ------------------------------------------------------------

void RandomKernel::together(const Flow& flow) {
    const std::string into = target();
    switch (below(8)) {
    case 0: {
        const std::string choice = condition();
        line("vote.sync.ballot.b32 " + into + ", " + choice + ", " + flow.mask);
        return;
    }
    case 1: {
        static constexpr const char* kVotes[] = {"all", "any", "uni"};
        const std::string choice = condition(), answer = fresh("%p");
        line(std::string("vote.sync.") + kVotes[below(3)] + ".pred " + answer + ", " + choice +
             ", " + flow.mask);
        line("selp.b32 " + into + ", " + varying() + ", " + varying() + ", " + answer);
        return;
    }
    case 2: {
        const std::string part = fresh("%t");
        line("and.b32 " + part + ", " + varying() + ", 3");
        line("match.any.sync.b32 " + into + ", " + part + ", " + flow.mask);
        return;
    }
    case 3: {
        static constexpr const char* kReductions[] = {"add.u32", "min.s32", "max.u32", "xor.b32"};
        line(std::string("redux.sync.") + kReductions[below(4)] + " " + into + ", " + varying() +
             ", " + flow.mask);
        return;
    }
    case 4:
        line("bar.warp.sync " + flow.mask);
        return;
    default: {
        static constexpr const char* kModes[] = {"up", "down", "bfly", "idx"};
        const size_t mode = below(4);
        const std::string distance = chance(60) ? number(32) : varying(), answer = fresh("%p");
        line(std::string("shfl.sync.") + kModes[mode] + ".b32 " + into + "|" + answer + ", " +
             varying() + ", " + distance + ", " + (mode == 0 ? "0" : "31") + ", " + flow.mask);
        if (chance(30))
            line("selp.b32 " + into + ", " + into + ", " + varying() + ", " + answer);
    }
    }
}

// All threads of the block exchange words through shared memory.
void RandomKernel::exchange() {
    const std::string other = fresh("%t"), place = fresh("%t");
    line("st.shared.u32 [%slot], " + varying());
    line("bar.sync 0");
    line("add.u32 " + other + ", %index, " + varying());
    line("rem.u32 " + other + ", " + other + ", %all");
    line("shl.b32 " + other + ", " + other + ", 2");
    line("add.u32 " + place + ", %slots, " + other);
    line("ld.shared.u32 " + target() + ", [" + place + "]");
    line("bar.sync 0");
    if (chance(40)) // the same in all
        line("ld.global.u32 " + name("%k", below(kCommon)) + ", [%in+" +
             std::to_string(4 * below(kInputWords)) + "]");
}

void RandomKernel::branch(const Flow& flow) {
    Flow inner = flow;
    ++inner.depth;
    const std::string other = label(), end = label();
    const bool hasOther = chance(60);
    std::string yes, no;
    if (flow.isWhole && chance(40)) { // all threads the same way
        const std::string choice = fresh("%p");
        line("setp.gt.u32 " + choice + ", " + name("%k", below(kCommon)) + ", " + number(3000));
        jump("!" + choice, other);
    } else {
        const std::string choice = condition();
        inner.isWhole = false;
        if (!flow.isUnknown()) {
            yes = fresh("%m");
            no = fresh("%m");
            line("vote.sync.ballot.b32 " + yes + ", " + choice + ", " + flow.mask);
            line("not.b32 " + no + ", " + yes);
            line("and.b32 " + no + ", " + no + ", " + flow.mask);
        }
        jump("!" + choice, other);
    }
    if (!yes.empty())
        inner.mask = yes;
    block(inner, 1 + unsigned(below(4)));
    if (hasOther)
        line("bra " + end);
    place(other);
    if (hasOther) {
        if (!no.empty())
            inner.mask = no;
        block(inner, 1 + unsigned(below(3)));
    }
    place(end);
}

// Two jumps forward that cross.
void RandomKernel::crossing(const Flow& flow) {
    Flow inner = flow;
    inner.mask.clear();
    inner.isWhole = false;
    ++inner.depth;
    const std::string first = label(), second = label();
    jump(condition(), first);
    block(inner, 1 + unsigned(below(2)));
    jump(condition(), second);
    block(inner, 1 + unsigned(below(2)));
    place(first);
    block(inner, 1 + unsigned(below(2)));
    place(second);
}

void RandomKernel::breakTogether(Flow& flow, const std::string& exit) {
    const std::string choice = condition();
    if (!flow.isUnknown()) {
        const std::string rest = fresh("%m");
        line("vote.sync.ballot.b32 " + rest + ", !" + choice + ", " + flow.mask);
        line("mov.b32 " + open_.back().next + "_mask, " + rest);
    }
    jump(choice, exit);
    flow.isWhole = false;
}

// Leaves enclosing loops that may be left in any way, continues with their next round, or ends the
// thread.
void RandomKernel::leave(const Flow&) {
    size_t outermost = open_.size();
    while (outermost > 0 && open_[outermost - 1].isWild)
        --outermost;
    const Loop& to = open_[outermost + below(open_.size() - outermost)];
    const std::string choice = condition();
    if (chance(40)) // records the exit of the loop
        line("mov.u32 " + name("%s", below(kAlike)) + ", " + number(9));
    if (chance(8)) {
        const std::string stay = label();
        jump("!" + choice, stay);
        finish();
        place(stay);
        return;
    }
    jump(choice, chance(70) ? to.exit : to.next);
}

void RandomKernel::loop(const Flow& flow) {
    const bool isWild = flow.mayLeave || chance(50);
    const std::string head = label(), count = fresh("%c"), bound = fresh("%t"), over = fresh("%p");
    const Loop made = {label(), label(), isWild};
    Flow inner = flow;
    ++inner.depth;
    ++inner.loops;
    inner.mayLeave = isWild;
    if (isWild) {
        inner.mask.clear();
        inner.isWhole = false;
    }
    // Whether all threads make the same number of rounds.
    const bool isCommon = chance(50);
    if (isCommon) {
        line("mov.u32 " + bound + ", " + std::to_string(1 + below(6)));
    } else {
        line("and.b32 " + bound + ", " + varying() + ", " + (chance(70) ? "3" : "7"));
        line("add.u32 " + bound + ", " + bound + ", 1");
        inner.isWhole = false;
    }
    const bool mayBreak = !isWild && chance(50);
    if (mayBreak)
        inner.isWhole = false;
    if (chance(30)) { // the counts may differ between threads
        line("mov.u32 " + count + ", %me");
        line("add.u32 " + bound + ", " + bound + ", %me");
    } else {
        line("mov.u32 " + count + ", 0");
    }
    // The lanes of a loop whose lanes are known.
    const std::string lanes = made.next + "_mask";
    if (!inner.isUnknown()) {
        body_ += "    .reg .b32 " + lanes + ";\n";
        line("mov.b32 " + lanes + ", " + flow.mask);
        inner.mask = lanes;
    }
    open_.push_back(made);
    counters_.push_back(count);
    const bool asksFirst = chance(50);
    const auto ask = [&](const char* compare) {
        line(std::string("setp.") + compare + ".u32 " + over + ", " + count + ", " + bound);
        if (!inner.isUnknown() && !isCommon) {
            const std::string stays = fresh("%m");
            line("vote.sync.ballot.b32 " + stays + ", " +
                 (compare == std::string("ge") ? "!" : "") + over + ", " + lanes);
            line("mov.b32 " + lanes + ", " + stays);
        }
    };
    place(head);
    if (chance(20)) // long code stays at the head
        for (int i = 0; i < 10; ++i)
            line("mad.lo.u32 %v0, %v0, 5, " + count);
    if (asksFirst) {
        ask("ge");
        jump(over, made.exit);
    }
    Flow part = inner;
    if (chance(50)) // the value common to all lanes of this round
        readAlike();
    block(part, unsigned(below(4)));
    if (mayBreak) {
        breakTogether(part, made.exit);
        block(part, 1 + unsigned(below(3)));
    }
    place(made.next);
    line("add.u32 " + count + ", " + count + ", 1");
    if (asksFirst) {
        line("bra " + head);
    } else {
        ask("lt");
        jump(over, head);
    }
    place(made.exit);
    open_.pop_back();
    if (chance(50)) // else its counter is used after it
        counters_.pop_back();
}

void RandomKernel::statement(const Flow& flow) {
    if (budget_ == 0)
        return;
    --budget_;
    if (flow.mayLeave && chance(25))
        return leave(flow);
    const size_t kind = below(100);
    const bool isDeep = flow.depth >= 5;
    if (kind < 22 && !isDeep && flow.loops < 3)
        return loop(flow);
    if (kind < 32 && !isDeep)
        return branch(flow);
    if (kind < 36 && !isDeep && flow.mayLeave)
        return crossing(flow);
    if (kind < 48)
        return flow.isUnknown() ? compute() : together(flow);
    if (kind < 54)
        return flow.isWhole ? exchange() : computeLong();
    if (kind < 68)
        return read();
    if (kind < 73)
        return ownMemory();
    if (kind < 80)
        return ownWords();
    if (kind < 83)
        return sum();
    if (kind < 87)
        return call();
    if (kind < 90)
        return computeReal();
    compute();
}

void RandomKernel::block(Flow flow, unsigned count) {
    const size_t known = counters_.size();
    for (; count > 0; --count)
        statement(flow);
    counters_.resize(known); // others may not have been written to
}

// Stores a digest of all registers and ends the thread.
void RandomKernel::finish() {
    line("mov.u32 %digest, 1");
    const auto add = [&](const std::string& what) {
        line("mad.lo.u32 %digest, %digest, 31, " + what);
    };
    for (unsigned i = 0; i < kVarying; ++i)
        add(name("%v", i));
    for (unsigned i = 0; i < kAlike; ++i)
        add(name("%s", i));
    for (const std::string& one : counters_)
        add(one);
    line("mad.wide.u32 %place, %me, 4, %out");
    line("st.global.u32 [%place], %digest");
    line("ret");
}

std::string RandomKernel::write() {
    budget_ = 4 + unsigned(below(chance(20) ? 45 : 16));
    line("ld.param.u64 %in, [in]");
    line("ld.param.u64 %out, [out]");
    line("ld.param.u64 %planes, [planes]");
    line("ld.param.u64 %sums, [sums]");
    line("ld.param.u32 %total, [n]");
    line("mov.u32 %index, %tid.x");
    line("mov.u32 %all, %ntid.x");
    line("mov.u32 %digest, %ctaid.x");
    line("mad.lo.u32 %me, %digest, %all, %index");
    line("mov.u32 %slots, slots");
    line("shl.b32 %slot, %index, 2");
    line("add.u32 %slot, %slot, %slots");
    line("st.shared.u32 [%slot], %me");
    line("mov.u64 %local, own");
    for (unsigned i = 0; i < 8; ++i)
        line("st.local.u32 [own+" + std::to_string(4 * i) + "], " + std::to_string(i * i));
    for (unsigned i = 0; i < kVarying; ++i) {
        const std::string from = fresh("%d"), index = fresh("%t");
        line("mad.lo.u32 " + index + ", %me, " + std::to_string(2 * i + 1) + ", " +
             std::to_string(7 * i));
        line("and.b32 " + index + ", " + index + ", " + std::to_string(kInputWords - 1));
        line("mad.wide.u32 " + from + ", " + index + ", 4, %in");
        line("ld.global.u32 " + name("%v", i) + ", [" + from + "]");
    }
    for (unsigned i = 0; i < kAlike; ++i)
        line("mov.u32 " + name("%s", i) + ", " + std::to_string(3 * i + 1));
    for (unsigned i = 0; i < kCommon; ++i)
        line("ld.global.u32 " + name("%k", i) + ", [%in+" + std::to_string(64 * i) + "]");
    Flow flow;
    flow.mask = "%m0";
    line("and.b32 %digest, %index, -32"); // the first thread of the warp
    line("sub.u32 %digest, %all, %digest");
    line("mov.u32 %m0, 1");
    line("shl.b32 %m0, %m0, %digest"); // 0 for whole warps
    line("sub.u32 %m0, %m0, 1");
    line("vote.sync.ballot.b32 %m0, 1, %m0");
    block(flow, 100);
    finish();

    const std::string most = "<" + std::to_string(registers_ + 1) + ">;\n";
    std::string text = ".version 7.1\n.target sm_80\n.address_size 64\n";
    text += kFunctions;
    text += ".visible .entry kernel(.param .u64 in, .param .u64 out, .param .u64 planes, "
            ".param .u64 sums, .param .u32 n)\n{\n";
    for (const char* kind : {"%t", "%m", "%c"})
        text += std::string("    .reg .b32 ") + kind + most;
    text += "    .reg .b64 %d" + most + "    .reg .f32 %f" + most + "    .reg .pred %p" + most;
    text += "    .reg .b32 %v<" + std::to_string(kVarying) + ">, %s<" + std::to_string(kAlike) +
            ">, %k<" + std::to_string(kCommon) + ">;\n";
    text += "    .reg .b32 %index, %all, %me, %slot, %slots, %digest, %total;\n"
            "    .reg .b64 %in, %out, %planes, %sums, %local, %place;\n"
            "    .shared .align 4 .b8 slots[" +
            std::to_string(4 * kMostThreads) +
            "];\n"
            "    .local .align 4 .b8 own[32];\n";
    return text + body_ + "}\n";
}

} // namespace fuzz
