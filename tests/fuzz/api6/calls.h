// SPDX-License-Identifier: Apache-2.0
// The parts of fuzz_api6: calls.cpp has the calls, scene.cpp scenes that can be launched, main.cpp
// the sequences.
#pragma once

#include "arguments.h"

#include <functional>
#include <initializer_list>

namespace fuzz {

struct Call {
    const char* name;
    unsigned weight;
    std::function<RTresult(World&)> run;
};

std::vector<Call> calls();

// Prints the finding, the present call and how to repeat the sequence; ends the process.
[[noreturn]] void fail(const std::string& what);

// The kinds of handles that are nodes of graphs, and an object of one of these kinds.
const std::vector<std::type_index>& nodes();
RTobject anyObject(World& w, const std::vector<std::type_index>& kinds);
RTprogram newProgram(World& w, RTcontext context, const char* name);

void createContext(World& w);
void destroyContext(World& w);
// Restores what a launch needs in a context, after calls have removed it.
RTresult repair(World& w);

} // namespace fuzz
