// SPDX-License-Identifier: Apache-2.0
// A structure of instances that follows its children. Their records change at once; boxes wait
// until the structure is updated. An update touches the children that have changed, as long as they
// are few and the tree stays good, and else builds the structure again.
#pragma once

#include "api/optix6/memory.h"
#include "bvh/refit/instance_paths.h"

#include <span>

namespace sunstone::optix6 {

class Context;

// What a node is in the structure of its parent. Rays enter `handle`, which is that of the
// description but for selectors: these have the bounds of all their children.
struct Child {
    bvh::InstanceDesc instance;
    uint64_t handle;
    uint64_t version; // of the structure behind the handle: changes with its bounds
};

class InstanceStructure {
public:
    explicit InstanceStructure(const std::shared_ptr<engine::Backend>& backend)
        : descriptions_(SharedAllocator<bvh::InstanceDesc>(backend)) {}

    uint64_t handle() const { return handle_; } // 0: nothing was built
    uint64_t version() const { return version_; }

    // All children. Those beyond the structure's size appear with the next update.
    void show(const std::vector<Child>& children);
    // Children from number `first` on, which exist already.
    void show(size_t first, std::span<const Child> children);
    // `refitsAll`: an update of all children is preferred to a build.
    void update(Context& context, bool refitsAll);

private:
    void showOne(size_t index, const Child& child);
    void write(size_t index);
    void build(Context& context);
    bool refit(Context& context, bool refitsAll);
    void refitAll(Context& context);
    bvh::InstanceInput input(const Context& context) const;

    std::vector<Child> children_;
    std::vector<uint32_t> stale_; // children whose boxes are those of an earlier place
    std::vector<bool> isStale_;
    SharedVector<bvh::InstanceDesc> descriptions_; // of the children, where the host's are foreign
    SharedMemory memory_, scratch_;
    uint64_t handle_ = 0, version_ = 0, instancesOffset_ = 0;
    size_t built_ = 0;   // children of the structure
    size_t moved_ = 0;   // children updated since it was built
    size_t special_ = 0; // children whose handle is not that of their description
    bvh::InstancePaths paths_;
};

} // namespace sunstone::optix6
