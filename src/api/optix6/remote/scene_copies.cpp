// SPDX-License-Identifier: Apache-2.0
#include "api/optix6/remote/scene_copies.h"

#include "api/optix6/remote/archive.h"
#include "api/optix6/remote/ranks.h"
#include "api/optix6/remote/remote_device.h"
#include "api/optix6/remote/scene_sender.h"
#include "base/log.h"

#include <algorithm>

namespace sunstone::optix6 {

SceneCopies::SceneCopies(Context& context) : context_(context) {}

SceneCopies::~SceneCopies() {
    drop();
}

void SceneCopies::drop() {
    Writer out;
    out.all(MessageKind::kDrop, number_);
    for (const uint32_t rank : holders_)
        Ranks::get()->send(rank, out.bytes);
    holders_.clear();
    sender_.reset();
}

std::vector<uint32_t> SceneCopies::wantedNodes(Ranks* ranks) const {
    std::vector<uint32_t> wanted;
    if (context_.usesRemoteDevice)
        wanted = reservedNodes(context_.remoteDevice);
    else if (ranks)
        wanted = ranks->alive();
    std::erase_if(wanted, [&](uint32_t rank) { return rank == 0 || !ranks->isAlive(rank); });
    return wanted;
}

uint64_t SceneCopies::start(const Launch& launch) {
    Ranks* const ranks = Ranks::get();
    std::vector<uint32_t> wanted = wantedNodes(ranks);
    if (wanted.empty())
        return 0;
    if (!ranks->acquire(this)) {
        log(LogLevel::kWarning, "optix6",
            "another context's progressive launch has the other ranks: this rank makes all "
            "subframes");
        return 0;
    }
    ranks_ = ranks;
    nodes_ = std::move(wanted);
    if (!std::includes(holders_.begin(), holders_.end(), nodes_.begin(), nodes_.end())) {
        drop();
        holders_ = nodes_;
        number_ = ranks->newNumber();
        sender_ = std::make_unique<SceneSender>();
    }
    Writer scene, start;
    scene.all(MessageKind::kScene, number_, sender_->changes(context_));
    for (const uint32_t rank : holders_)
        ranks->send(rank, scene.bytes);
    std::vector<uint64_t> sources;
    for (const std::shared_ptr<Buffer>& source : launch.sources)
        sources.push_back(reinterpret_cast<uint64_t>(source->handle()));
    const uint64_t number = ranks->newNumber();
    start.all(MessageKind::kStart, number, number_, launch.entry, launch.width, launch.height,
              sources);
    for (const uint32_t rank : nodes_)
        ranks->send(rank, start.bytes);
    return number;
}

void SceneCopies::release() {
    if (ranks_)
        ranks_->release(this);
    ranks_ = nullptr;
    nodes_.clear();
}

} // namespace sunstone::optix6
