// SPDX-License-Identifier: Apache-2.0
// Builds the functions of one ABI's table. Adapter<kAbi, function>::call has the C signature of the
// slot, converts arguments that differ between ABIs to our form and calls the function. The types
// of the arguments decide which are converted (client_structs.h); all others are passed unchanged.
#pragma once

#include "api/optix7/client_structs.h"
#include "base/forked.h"

namespace sunstone::optix7 {

// One argument; Client is its type in the slot's signature.
template <Abi kAbi, class Ours>
class Argument {
public:
    using Client = Ours;
    explicit Argument(Client given) : given_(given) {}
    Ours get() { return given_; }
    void finish(OptixResult) {}

private:
    Client given_;
};

template <Abi kAbi, DiffersBetweenAbis T>
class Argument<kAbi, const T*> {
public:
    using Client = const T*;
    explicit Argument(Client given) : isNull_(!given) {
        if (given)
            ours_ = fromClient<T>(given, kAbi);
    }
    const T* get() { return isNull_ ? nullptr : &ours_; }
    void finish(OptixResult) {}

private:
    bool isNull_;
    T ours_;
};

// A result returned through a pointer: on success only the client's bytes are written.
template <Abi kAbi, DiffersBetweenAbis T>
class Argument<kAbi, T*> {
public:
    using Client = T*;
    explicit Argument(Client given) : given_(given) {
        std::memset(static_cast<void*>(&ours_), 0, sizeof(T)); // including padding
    }
    T* get() { return given_ ? &ours_ : nullptr; }
    void finish(OptixResult result) {
        if (given_ && result == OPTIX_SUCCESS)
            std::memcpy(static_cast<void*>(given_), &ours_, clientBytes<T>(kAbi));
    }

private:
    T* given_;
    T ours_;
};

template <Abi kAbi>
class Argument<kAbi, BuildInputs> {
public:
    using Client = const OptixBuildInput*;
    explicit Argument(Client given) : given_(given) {}
    BuildInputs get() { return BuildInputs(given_, kAbi); }
    void finish(OptixResult) {}

private:
    Client given_;
};

// The result of every function in the child of a fork.
constexpr OptixResult kInForkedChild = OPTIX_ERROR_CUDA_NOT_INITIALIZED;

template <Abi kAbi, auto kFunction>
struct Adapter;
template <Abi kAbi, class... Ours, OptixResult (*kFunction)(Ours...)>
struct Adapter<kAbi, kFunction> {
    static OptixResult call(typename Argument<kAbi, Ours>::Client... given) {
        if (refusesForkedChild())
            return kInForkedChild;
        return forward(Argument<kAbi, Ours>(given)...);
    }

private:
    static OptixResult forward(Argument<kAbi, Ours>... arguments) {
        const OptixResult result = kFunction(arguments.get()...);
        (arguments.finish(result), ...);
        return result;
    }
};
// A function that depends on the ABI takes it as first argument.
template <Abi kAbi, class... Ours, OptixResult (*kFunction)(Abi, Ours...)>
struct Adapter<kAbi, kFunction> {
    static OptixResult call(typename Argument<kAbi, Ours>::Client... given) {
        if (refusesForkedChild())
            return kInForkedChild;
        return forward(Argument<kAbi, Ours>(given)...);
    }

private:
    static OptixResult forward(Argument<kAbi, Ours>... arguments) {
        const OptixResult result = kFunction(kAbi, arguments.get()...);
        (arguments.finish(result), ...);
        return result;
    }
};

} // namespace sunstone::optix7
