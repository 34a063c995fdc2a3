// SPDX-License-Identifier: Apache-2.0
// Command lists: launches and post-processing stages in the order in which they run.
#pragma once

#include "api/optix6/post/stage.h"

namespace sunstone::optix6 {

class CommandList : public Object {
public:
    static constexpr Kind kKind = Kind::kCommandList;
    explicit CommandList(const std::shared_ptr<Context>& context) : Object(kKind, context) {}

    void append(const std::shared_ptr<PostProcessingStage>& stage);
    void append(unsigned entryPoint, RTsize width, RTsize height);
    void finalize();
    void execute();

private:
    struct Command {
        bool isLaunch;
        unsigned entryPoint;
        RTsize width, height;
        Ref<PostProcessingStage> stage;
    };
    void requireOpen() const;
    // Throws if a stage has been destroyed.
    void requireStages() const;

    std::vector<Command> commands_;
    bool isFinal_ = false;
};

} // namespace sunstone::optix6
