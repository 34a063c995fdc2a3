// SPDX-License-Identifier: Apache-2.0
// Loaded code and its debug information: registers code with gdb and finds the source line of an
// address.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

namespace sunstone::compiler {

// Where the sections of an object file were loaded, by name.
using SectionAddresses = std::map<std::string, uint64_t>;

// Keeps facts about an object's code during its lifetime: the names of its functions and, if
// present, its lines and variables.
class DebugRegistration {
public:
    // code: the object file. forDebugger: also registers it with gdb, for lines and variables (GDB
    // manual, "JIT Compilation Interface"). Null if the object has no code.
    static std::unique_ptr<DebugRegistration> add(const std::string& code,
                                                  const SectionAddresses& addresses,
                                                  bool forDebugger);
    ~DebugRegistration();
    DebugRegistration(const DebugRegistration&) = delete;
    DebugRegistration& operator=(const DebugRegistration&) = delete;

private:
    DebugRegistration() = default;
    struct Entry;
    std::unique_ptr<Entry> entry_;
};

} // namespace sunstone::compiler
