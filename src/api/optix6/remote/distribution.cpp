// SPDX-License-Identifier: Apache-2.0
#include "api/optix6/remote/distribution.h"

#include "api/optix6/remote/archive.h"
#include "base/log.h"

#include <algorithm>

namespace sunstone::optix6 {

namespace {

constexpr double kSecondsOfRange = 0.2;
constexpr size_t kRangesAhead = 2; // so that nodes need not wait
constexpr unsigned kMostInRange = 4096;

} // namespace

Distribution::Distribution(Ranks* ranks, std::vector<uint32_t> nodes, uint64_t launch,
                           unsigned limit)
    : ranks_(ranks), launch_(launch), limit_(limit) {
    counts_[0] = 0;
    for (const uint32_t rank : nodes) {
        nodes_[rank];
        counts_[rank] = 0;
    }
}

Distribution::~Distribution() {
    if (!ranks_)
        return;
    Writer out;
    out.all(MessageKind::kStop, launch_);
    for (const auto& [rank, node] : nodes_)
        ranks_->send(rank, out.bytes);
    std::string text = "subframes of ranks";
    for (const auto& [rank, count] : counts_)
        text += message(" ", rank, ":", count);
    log(LogLevel::kInfo, "optix6", text);
}

// Takes up to `most` subframes that no rank has taken; a count of 0 means that none is left.
Distribution::Range Distribution::cut(unsigned most) {
    if (!open_.empty()) {
        Range& range = open_.front();
        const Range part{range.first, std::min(most, range.count)};
        range.first += part.count;
        range.count -= part.count;
        if (range.count == 0)
            open_.pop_front();
        return part;
    }
    const unsigned left = limit_ ? limit_ - next_ : most;
    const Range range{next_, std::min(most, left)};
    next_ += range.count;
    return range;
}

std::optional<unsigned> Distribution::take() {
    const Range range = cut(1);
    return range.count ? std::optional(range.first) : std::nullopt;
}

// Towards the end ranges get shorter, so that all ranks end at the same time.
void Distribution::give(uint32_t rank) {
    Node& node = nodes_.at(rank);
    while (node.given.size() < kRangesAhead) {
        unsigned most = 1;
        if (node.secondsEach > 0)
            most =
                unsigned(std::clamp(kSecondsOfRange / node.secondsEach, 1.0, double(kMostInRange)));
        if (limit_)
            most = std::min(most, std::max(1u, (limit_ - next_) / unsigned(2 * nodes_.size() + 2)));
        const Range range = cut(most);
        if (range.count == 0)
            return;
        node.given.push_back(range);
        Writer out;
        out.all(MessageKind::kWork, launch_, range.first, range.count);
        ranks_->send(rank, out.bytes);
    }
}

void Distribution::takeBack(uint32_t rank) {
    const auto found = nodes_.find(rank);
    if (found == nodes_.end())
        return;
    open_.insert(open_.end(), found->second.given.begin(), found->second.given.end());
    nodes_.erase(found);
}

void Distribution::takeSums(uint32_t rank, Reader& in, const Add& add) {
    const auto found = nodes_.find(rank);
    Range range{};
    double seconds = 0;
    in.all(range.first, range.count, seconds);
    if (found == nodes_.end() || found->second.given.empty() ||
        found->second.given.front().first != range.first)
        return;
    found->second.given.pop_front();
    found->second.secondsEach = std::max(seconds, 1e-9) / std::max(1u, range.count);
    add(range.count, in);
    made_ += range.count;
    counts_[rank] += range.count;
}

void Distribution::receive(int milliseconds, const Add& add) {
    if (nodes_.empty())
        return;
    for (auto node = nodes_.begin(); node != nodes_.end();) {
        const uint32_t rank = (node++)->first;
        if (ranks_->isAlive(rank))
            give(rank);
        else
            takeBack(rank);
    }
    while (const std::optional<Message> message = ranks_->receive(milliseconds)) {
        milliseconds = 0;
        Reader in(message->bytes);
        const auto kind = in.get<MessageKind>();
        if (kind == MessageKind::kDied) {
            takeBack(message->rank);
            continue;
        }
        if (in.get<uint64_t>() != launch_)
            continue; // of an earlier launch
        if (kind == MessageKind::kSums) {
            takeSums(message->rank, in, add);
        } else if (kind == MessageKind::kFailed) {
            log(LogLevel::kError, "optix6",
                sunstone::message("rank ", message->rank,
                                  " takes no part in the launch: ", in.get<std::string>()));
            takeBack(message->rank);
        }
        if (nodes_.count(message->rank))
            give(message->rank);
    }
}

} // namespace sunstone::optix6
