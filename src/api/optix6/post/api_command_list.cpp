// SPDX-License-Identifier: Apache-2.0
// Command lists and their entry points (section 5.19).
#include "api/optix6/call.h"
#include "api/optix6/gl/share.h"
#include "api/optix6/post/command_list.h"

using namespace sunstone;
using namespace sunstone::optix6;

namespace sunstone::optix6 {

void CommandList::requireOpen() const {
    if (isFinal_)
        refuse(RT_ERROR_INVALID_VALUE, "list has been finalized: it takes no more commands");
}

void CommandList::requireStages() const {
    for (size_t i = 0; i < commands_.size(); ++i)
        if (!commands_[i].isLaunch && commands_[i].stage.expired())
            refuse(RT_ERROR_INVALID_VALUE, "the stage of command ", i,
                   " has been destroyed: the list cannot be used any more");
}

void CommandList::append(const std::shared_ptr<PostProcessingStage>& stage) {
    requireOpen();
    commands_.push_back({false, 0, 0, 0, stage});
}

void CommandList::append(unsigned entryPoint, RTsize width, RTsize height) {
    requireOpen();
    commands_.push_back({true, entryPoint, width, height, {}});
}

void CommandList::finalize() {
    if (isFinal_)
        refuse(RT_ERROR_INVALID_VALUE, "list has been finalized before");
    requireStages();
    isFinal_ = true;
}

void CommandList::execute() {
    if (!isFinal_)
        refuse(RT_ERROR_INVALID_VALUE, "list has not been finalized");
    requireStages();
    const std::shared_ptr<Context> owner = context();
    gl::Share share(*owner);
    for (const Command& command : commands_)
        if (!command.isLaunch) // before a launch writes to buffers whose data OpenGL lacks
            share.fetch(*command.stage.lock());
    for (const Command& command : commands_) {
        if (command.isLaunch)
            launchEntry(*owner, command.entryPoint, command.width, command.height, 1);
        else
            command.stage.lock()->run();
    }
    share.giveBack();
}

} // namespace sunstone::optix6

namespace {

template <class Body>
RTresult callList(const char* function, RTcommandlist list, const Body& body) {
    return call<CommandList>(function, list, "list", body);
}

} // namespace

SUNSTONE_API RTresult rtCommandListCreate(RTcontext context, RTcommandlist* list) {
    return create<CommandList>(__func__, context, "list", list);
}

SUNSTONE_API RTresult rtCommandListDestroy(RTcommandlist list) {
    return callList(__func__, list, [&](CommandList&) { objects().remove(list); });
}

// The sizes are hints: stages work on whole buffers.
SUNSTONE_API RTresult rtCommandListAppendPostprocessingStage(RTcommandlist list,
                                                             RTpostprocessingstage stage, RTsize,
                                                             RTsize) {
    return callList(__func__, list, [&](CommandList& object) {
        object.append(requireOf<PostProcessingStage>(*object.context(), stage, "stage"));
    });
}

SUNSTONE_API RTresult rtCommandListAppendLaunch2D(RTcommandlist list, unsigned entryPoint,
                                                  RTsize width, RTsize height) {
    return callList(__func__, list,
                    [&](CommandList& object) { object.append(entryPoint, width, height); });
}

SUNSTONE_API RTresult rtCommandListFinalize(RTcommandlist list) {
    return callList(__func__, list, [](CommandList& object) { object.finalize(); });
}

SUNSTONE_API RTresult rtCommandListExecute(RTcommandlist list) {
    return callList(__func__, list, [](CommandList& object) { object.execute(); });
}

SUNSTONE_API RTresult rtCommandListGetContext(RTcommandlist list, RTcontext* context) {
    if (context)
        *context = nullptr;
    return callList(__func__, list, [&](CommandList& object) {
        if (context)
            *context = static_cast<RTcontext>(object.context()->handle());
    });
}
