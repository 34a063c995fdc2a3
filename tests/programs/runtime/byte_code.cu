// SPDX-License-Identifier: Apache-2.0
// A virtual machine on the device: threads interpret different programs with a switch in a loop, a
// stack in local memory, calls and jumps; the host runs the same source and compares registers.
#include "device.h"

#include <vector>

enum Code : unsigned char {
    kPush,
    kAdd,
    kSub,
    kMul,
    kMod,
    kDup,
    kSwap,
    kOver,
    kDrop,
    kLess,
    kJump,
    kJumpIfZero,
    kCall,
    kReturn,
    kLoad,
    kStore,
    kHalt
};

struct Machine {
    int memory[16];
    int depth, steps, error;
};

__host__ __device__ void interpret(const unsigned char* code, int length, int input, Machine& m) {
    int stack[24], calls[8];
    int sp = 0, rp = 0, pc = 0;
    for (int i = 0; i < 16; ++i)
        m.memory[i] = input + i;
    m.error = 0;
    for (m.steps = 0; m.steps < 400; ++m.steps) {
        if (pc < 0 || pc >= length || sp > 20) {
            m.error = 1;
            break;
        }
        const unsigned char op = code[pc++];
        const int needed =
            op == kPush || op == kJump || op == kCall || op == kReturn || op == kHalt || op == kLoad
                ? 0
            : op == kDup || op == kDrop || op == kJumpIfZero || op == kStore ? 1
                                                                             : 2;
        if (sp < needed) {
            m.error = 2;
            break;
        }
        switch (op) {
        case kPush:
            stack[sp++] = (signed char)code[pc++];
            break;
        case kAdd:
            --sp;
            stack[sp - 1] += stack[sp];
            break;
        case kSub:
            --sp;
            stack[sp - 1] -= stack[sp];
            break;
        case kMul:
            --sp;
            stack[sp - 1] = int(unsigned(stack[sp - 1]) * unsigned(stack[sp]));
            break;
        case kMod:
            --sp;
            stack[sp - 1] = stack[sp] > 0 ? stack[sp - 1] % stack[sp] : 0;
            break;
        case kDup:
            stack[sp] = stack[sp - 1];
            ++sp;
            break;
        case kSwap: {
            const int t = stack[sp - 1];
            stack[sp - 1] = stack[sp - 2];
            stack[sp - 2] = t;
            break;
        }
        case kOver:
            stack[sp] = stack[sp - 2];
            ++sp;
            break;
        case kDrop:
            --sp;
            break;
        case kLess:
            --sp;
            stack[sp - 1] = stack[sp - 1] < stack[sp];
            break;
        case kJump:
            pc += (signed char)code[pc];
            break;
        case kJumpIfZero:
            pc += stack[--sp] == 0 ? (signed char)code[pc] : 1;
            break;
        case kCall:
            if (rp == 8) {
                m.error = 3;
                goto done;
            }
            calls[rp++] = pc + 1;
            pc = code[pc] % length;
            break;
        case kReturn:
            if (rp == 0)
                goto done;
            pc = calls[--rp];
            break;
        case kLoad:
            stack[sp++] = m.memory[code[pc++] & 15];
            break;
        case kStore:
            m.memory[code[pc++] & 15] = stack[--sp];
            break;
        case kHalt:
            goto done;
        default:
            m.error = 4;
            goto done;
        }
    }
done:
    m.depth = sp;
    for (int i = 0; i < sp; ++i)
        m.memory[i & 15] ^= stack[i] * (i + 1);
}

__global__ void run(const unsigned char* code, const int2* programs, Machine* machines, int count) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < count)
        interpret(code + programs[i].x, programs[i].y, i, machines[i]);
}

int main() {
    const int count = 500;
    std::vector<unsigned char> code;
    std::vector<int2> programs(count);
    unsigned state = 1;
    // A loop that adds up squares, then random programs.
    const unsigned char loop[] = {kPush,
                                  0,
                                  kStore,
                                  0,
                                  kPush,
                                  20,
                                  kStore,
                                  1,
                                  kLoad,
                                  1,
                                  kDup,
                                  kMul,
                                  kLoad,
                                  0,
                                  kAdd,
                                  kStore,
                                  0,
                                  kLoad,
                                  1,
                                  kPush,
                                  1,
                                  kSub,
                                  kDup,
                                  kStore,
                                  1,
                                  kLoad,
                                  1,
                                  kJumpIfZero,
                                  3,
                                  kJump,
                                  (unsigned char)-20,
                                  kHalt,
                                  kHalt};
    for (int i = 0; i < count; ++i) {
        programs[i].x = int(code.size());
        if (i % 3 == 0)
            code.insert(code.end(), loop, loop + sizeof(loop));
        else
            for (int j = 0; j < 20 + i % 50; ++j) {
                state = state * 1664525u + 1013904223u;
                code.push_back((unsigned char)((state >> 12) % (j < 6 ? 1 : 18)));
            }
        programs[i].y = int(code.size()) - programs[i].x;
        code.insert(code.end(), 2, kHalt);
    }
    unsigned char* deviceCode;
    int2* devicePrograms;
    Machine* deviceMachines;
    std::vector<Machine> machines(count);
    CUDA(cudaMalloc(&deviceCode, code.size()));
    CUDA(cudaMalloc(&devicePrograms, count * sizeof(int2)));
    CUDA(cudaMalloc(&deviceMachines, count * sizeof(Machine)));
    CUDA(cudaMemcpy(deviceCode, code.data(), code.size(), cudaMemcpyHostToDevice));
    CUDA(cudaMemcpy(devicePrograms, programs.data(), count * sizeof(int2), cudaMemcpyHostToDevice));
    run<<<(count + 63) / 64, 64>>>(deviceCode, devicePrograms, deviceMachines, count);
    CUDA(cudaMemcpy(machines.data(), deviceMachines, count * sizeof(Machine),
                    cudaMemcpyDeviceToHost));
    int wrong = 0, ended = 0;
    for (int i = 0; i < count; ++i) {
        Machine m;
        interpret(code.data() + programs[i].x, programs[i].y, i, m);
        bool same = m.depth == machines[i].depth && m.steps == machines[i].steps &&
                    m.error == machines[i].error;
        for (int j = 0; j < 16; ++j)
            same = same && m.memory[j] == machines[i].memory[j];
        wrong += !same;
        ended += m.error == 0;
    }
    std::printf("%d programs end, %d wrong\n", ended, wrong);
    return finish(wrong == 0 && ended >= count / 3);
}
