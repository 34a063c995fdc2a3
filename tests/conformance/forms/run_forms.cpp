// SPDX-License-Identifier: Apache-2.0
// See run_forms.h. Workers are forked before the driver is loaded and take lists of forms from a
// common counter; results are in memory shared by all. A failing list is halved until each failing
// form is isolated.
#include "forms/run_forms.h"

#include "case_processes.h"
#include "driver.h"
#include "inputs.h"
#include "module_writer.h"

#include <atomic>
#include <cstdio>
#include <cstring>
#include <memory>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace conformance {

namespace {

constexpr unsigned kMostWorkers = 64;
constexpr int kNone = -1;

struct Shared {
    std::atomic<int> next;                  // list
    std::atomic<int> current[kMostWorkers]; // list a worker is at
    char device[200];
};

// Memory shared by all processes.
struct World {
    const std::vector<Form>& forms;
    std::vector<size_t> offsets; // by form, in `results`
    uint8_t* results = nullptr;
    Status* status = nullptr;
    Shared* shared = nullptr;
};

class Runner {
public:
    explicit Runner(World& world) : world_(world) {
        const std::vector<uint64_t> inputs = allInputs();
        inputs_ = driver_.allocate(inputs.size() * 8);
        driver_.copyIn(inputs_, inputs.data(), inputs.size() * 8);
        scratch_ = driver_.allocate(size_t(kVectors) * kScratch);
        const std::string device = driver_.describe();
        std::strncpy(world_.shared->device, device.c_str(), sizeof world_.shared->device - 1);
    }

    void run(const std::vector<size_t>& numbers) {
        if (numbers.empty() || runModule(numbers))
            return;
        if (numbers.size() == 1) {
            world_.status[numbers[0]] = Status::kRefused;
            return;
        }
        const auto middle = numbers.begin() + std::ptrdiff_t(numbers.size() / 2);
        run({numbers.begin(), middle});
        run({middle, numbers.end()});
    }

private:
    // False if the module is refused.
    bool runModule(const std::vector<size_t>& numbers) {
        const ModuleText text = writeModule(world_.forms, numbers);
        CUmodule module = nullptr;
        if (driver_.cuModuleLoadDataEx(&module, text.ptx.c_str(), 0, nullptr, nullptr) !=
            CUDA_SUCCESS)
            return false;
        const CUdeviceptr out = driver_.allocate(text.bytes);
        driver_.clear(out, text.bytes);
        bool good = true;
        for (const KernelText& kernel : text.kernels)
            good = good && launch(module, kernel.name.c_str(), out);
        std::vector<uint8_t> results(text.bytes);
        if (good && (driver_.cuCtxSynchronize() != CUDA_SUCCESS ||
                     !driver_.copyOut(results.data(), out, results.size())))
            _exit(3); // the context is lost
        driver_.release(out);
        driver_.cuModuleUnload(module);
        if (good)
            keep(text, results);
        return good;
    }

    bool launch(CUmodule module, const char* name, CUdeviceptr out) {
        CUfunction function = nullptr;
        CUdeviceptr in = inputs_, scratch = scratch_;
        void* parameters[] = {&in, &out, &scratch};
        return driver_.cuModuleGetFunction(&function, module, name) == CUDA_SUCCESS &&
               driver_.cuLaunchKernel(function, kVectors / 32, 1, 1, 32, 1, 1, 0, nullptr,
                                      parameters, nullptr) == CUDA_SUCCESS;
    }

    void keep(const ModuleText& text, const std::vector<uint8_t>& results) {
        size_t i = 0;
        for (const KernelText& kernel : text.kernels)
            for (const size_t number : kernel.forms) {
                std::memcpy(world_.results + world_.offsets[number],
                            results.data() + text.offsets[i++], resultBytes(world_.forms[number]));
                world_.status[number] = Status::kDone;
            }
    }

    World& world_;
    Driver driver_;
    CUdeviceptr inputs_ = 0, scratch_ = 0;
};

// Runs lists until none is left; the process ends.
[[noreturn]] void work(World& world, const std::vector<std::vector<size_t>>& lists,
                       unsigned worker) {
    Runner runner(world);
    for (;;) {
        const int list = world.shared->next++;
        if (list >= int(lists.size()))
            break;
        world.shared->current[worker] = list;
        runner.run(lists[size_t(list)]);
        world.shared->current[worker] = kNone;
    }
    std::fflush(stderr);
    _exit(0);
}

// Runs lists on several processes; returns those whose process died.
std::vector<std::vector<size_t>>
runLists(World& world, const std::vector<std::vector<size_t>>& lists, unsigned workers) {
    std::vector<std::vector<size_t>> failed;
    world.shared->next = 0;
    workers = unsigned(std::min<size_t>(workers, lists.size()));
    while (world.shared->next < int(lists.size())) {
        pid_t children[kMostWorkers];
        for (unsigned i = 0; i < workers; ++i) {
            world.shared->current[i] = kNone;
            children[i] = fork();
            if (children[i] == 0)
                work(world, lists, i);
        }
        for (unsigned i = 0; i < workers; ++i) {
            int state = 0;
            waitpid(children[i], &state, 0);
            const int list = world.shared->current[i];
            if (WIFEXITED(state) && WEXITSTATUS(state) == 0)
                continue;
            if (list == kNone) // before its first list, for example without a device
                quit(WIFEXITED(state) ? WEXITSTATUS(state) : 1, "a worker could not start");
            failed.push_back(lists[size_t(list)]);
        }
    }
    return failed;
}

} // namespace

Results runForms(const std::vector<Form>& forms, const std::vector<size_t>& numbers,
                 unsigned workers) {
    if (workers == 0)
        workers = std::max(1u, std::thread::hardware_concurrency());
    workers = std::min(workers, kMostWorkers);
    World world{forms, {}, nullptr, nullptr, nullptr};
    size_t bytes = 0;
    for (const Form& form : forms) {
        world.offsets.push_back(bytes);
        bytes += resultBytes(form);
    }
    world.results = share<uint8_t>(bytes);
    world.status = share<Status>(forms.size());
    world.shared = share<Shared>(1);

    std::vector<std::vector<size_t>> lists = splitForms(forms, numbers);
    while (!lists.empty()) {
        std::vector<std::vector<size_t>> again;
        for (const std::vector<size_t>& failed : runLists(world, lists, workers)) {
            std::vector<size_t> left;
            for (const size_t number : failed)
                if (world.status[number] == Status::kPending)
                    left.push_back(number);
            if (left.size() == 1) {
                world.status[left[0]] = Status::kCrashed;
                continue;
            }
            const auto middle = left.begin() + std::ptrdiff_t(left.size() / 2);
            if (left.empty())
                continue;
            again.emplace_back(left.begin(), middle);
            again.emplace_back(middle, left.end());
        }
        lists = std::move(again);
    }

    Results all;
    all.device = world.shared->device;
    for (size_t i = 0; i < forms.size(); ++i) {
        all.status.push_back(world.status[i]);
        const uint8_t* start = world.results + world.offsets[i];
        all.results.emplace_back();
        if (world.status[i] == Status::kDone)
            all.results.back().assign(start, start + resultBytes(forms[i]));
    }
    return all;
}

} // namespace conformance
