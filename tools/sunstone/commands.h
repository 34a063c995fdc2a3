// SPDX-License-Identifier: Apache-2.0
// The commands of `sunstone`. Each returns the program's exit code, or throws std::exception with
// one clear line.
#pragma once

#include <string>
#include <vector>

namespace sunstone::tool {

int info(bool json);

struct RunOptions {
    bool check = false;      // memory accesses of device code
    bool leakCheck = false;  // device memory that is never freed
    bool hostMemory = false; // ordinary memory of the process may be accessed
    std::string json;        // file for the reports
    std::vector<std::string> command;
};
// Replaces this process by the command, with the libraries' folders in front of LD_LIBRARY_PATH.
// With checks it waits for the command: 1 if anything was reported, else the command's exit code.
int run(const RunOptions& options);
// Evaluates the reports of a checked run, from the lines that the libraries wrote
// (src/check/memory_check.h): prints a summary and writes the JSON file if requested. Returns
// whether there were reports.
bool summarize(const std::string& lines, const RunOptions& options);

// Fills the disk cache for the GPUs of this machine; without a GPU only prints a message.
int warm();

struct CheckOptions {
    std::string file;
    std::string launchParams = "params";
    bool json = false;
};
int check(const CheckOptions& options);

struct RenderOptions {
    std::string model;
    std::string output = "out.png";
    unsigned width = 960, height = 540, samples = 64;
    unsigned bounces = 4;
    float azimuth = 38.0f, elevation = 24.0f, zoom = 1.0f;
    std::vector<float> eye, lookAt; // empty: an orbit around the model
    float fov = 34.0f;
    bool ground = true;
    bool zUp = false;
};
int render(const RenderOptions& options);

// The folders of the libraries; empty if this program was moved away from them.
struct Folders {
    std::string lib;  // libnvoptix.so.1
    std::string cuda; // libcuda.so.1, libcudart
};
Folders findFolders();

// Whether `mpirun -n N sunstone run` runs a program of the classic API that does not use MPI
// itself; see ranks.cpp.
bool runsOnRanks(const std::vector<std::string>& command);
// Runs this process's rank; on rank 0, returns the program's exit code.
int runOnRanks(const Folders& folders, const std::vector<std::string>& command);
// The process of another rank: renders subframes for the program until the socket is closed.
int serveNode(int socket, unsigned device);

} // namespace sunstone::tool
