// SPDX-License-Identifier: Apache-2.0
// Writes random kernels whose result does not depend on how their threads run.
//
// Threads diverge through branches, loops with several exits that they leave at different times,
// crossing jumps, calls and early ends. A kernel reads only constant memory, memory of its thread,
// and shared memory between two barriers that all threads reach; to other shared data it only adds.
// Warp functions name exactly the lanes that arrive: the kernel tracks their mask where it can be
// known, and has no warp functions elsewhere.
#pragma once

#include <random>
#include <string>
#include <vector>

namespace fuzz {

constexpr unsigned kInputWords = 1024, kPlanes = 4, kSums = 8, kMostThreads = 256;

class RandomKernel {
public:
    explicit RandomKernel(unsigned long number) : random_(number * 7919 + 1) {}
    // A module with the entry point `kernel(in, out, planes, sums, n)`.
    std::string write();

private:
    // The generator's knowledge of the threads that reach a statement.
    struct Flow {
        std::string mask;      // register with the lanes of the warp that are here; "": not known
        bool isWhole = true;   // all threads that have not ended
        unsigned depth = 0;    // of branches and loops
        unsigned loops = 0;    // around
        bool mayLeave = false; // loops may be left from here in any way
        bool isUnknown() const { return mask.empty(); }
    };
    struct Loop {
        std::string next, exit; // labels
        bool isWild;            // may be left from anywhere within
    };

    size_t below(size_t limit) { return random_() % limit; }
    bool chance(size_t percent) { return below(100) < percent; }
    std::string number(size_t limit) { return std::to_string(below(limit)); }
    std::string label() { return "L" + std::to_string(labels_++); }
    std::string fresh(const char* kind) { return kind + std::to_string(registers_++); }
    void line(const std::string& text) { body_ += "    " + text + ";\n"; }
    void place(const std::string& label) { body_ += label + ":\n"; }
    void jump(const std::string& predicate, const std::string& label) {
        line("@" + predicate + " bra " + label);
    }

    std::string varying(); // a register or, seldom, a number
    std::string target();  // a register to write
    std::string counter(); // of an outer loop, or common to all threads
    std::string condition();
    std::string address(const std::string& index, const std::string& base, unsigned words);

    void block(Flow flow, unsigned count);
    void statement(const Flow& flow);
    void compute();
    void computeReal();
    void computeLong();
    void read();
    void readAlike();
    void ownMemory();
    void ownWords();
    void sum();
    void call();
    void together(const Flow& flow);
    void exchange();
    void branch(const Flow& flow);
    void crossing(const Flow& flow);
    void loop(const Flow& flow);
    void leave(const Flow& flow);
    void breakTogether(Flow& flow, const std::string& exit);
    void finish();

    std::mt19937_64 random_;
    std::string body_;
    std::vector<Loop> open_;
    std::vector<std::string> counters_;
    std::string latest_; // register that readAlike has written
    unsigned labels_ = 0, registers_ = 1, budget_ = 0;
};

} // namespace fuzz
