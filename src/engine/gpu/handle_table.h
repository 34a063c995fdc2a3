// SPDX-License-Identifier: Apache-2.0
// The valid handles of the process, and the table of them that each CUDA context keeps in its
// memory (structures.h): handles may be used in any context.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <unordered_map>
#include <vector>

namespace sunstone::engine {

// Which traversables the process has built or declared. What graphs() has returned as true stays
// true.
struct GpuGraphs {
    bool any = false;       // a structure or a transform
    bool instances = false; // an instance structure or a transform
    bool deep = false;      // transforms, or two instance structures: paths of more than two
    bool motion = false;    // a structure with motion keys, or a motion transform
    bool keys = false;      // a structure with motion keys
};

// A handle keeps its place until the layout changes. The caller holds the mutex.
class GpuHandleTable {
public:
    std::mutex mutex;

    // moves: the structure has motion keys.
    void note(uint64_t handle, bool moves);
    // Checks `count` structures with the driver, continuing after those of the last call.
    void look(size_t count);
    // `handle` if it is valid, else the newest structure's handle if that is valid, else 0.
    uint64_t usual(uint64_t handle);
    const GpuGraphs& graphs();
    // Lays out a table if there is none, or if the list of changes is much longer than the table.
    void tidy();

    std::vector<uint64_t> slots;
    uint64_t layout = 0;          // counts changes of all places
    std::vector<uint32_t> writes; // places written since then, in order
    unsigned shift() const;

private:
    struct Entry {
        uint64_t handle = 0;
        uint32_t place = 0;
        bool isThere = true;
        uint64_t allocation = 0; // of the driver's; 0: none, and not checked
    };

    bool look(Entry& entry);
    void set(Entry& entry, bool isThere);
    void enter(Entry& entry);
    void lay();

    std::unordered_map<uint64_t, Entry> entries_;
    std::vector<uint64_t> order_;
    size_t next_ = 0;
    uint64_t newest_ = 0;
    // Handles of instance structures; at most one after graphs() has returned, unless it is deep.
    std::vector<uint64_t> instanceStructures_;
    GpuGraphs graphs_;
};

} // namespace sunstone::engine
