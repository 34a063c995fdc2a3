// SPDX-License-Identifier: Apache-2.0
// The command `sunstone`: shows this installation, runs programs with it, checks PTX, renders
// models.
#include "commands.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

using namespace sunstone::tool;

namespace {

// CLI::Range accepts nan.
const CLI::Validator kFinite(
    [](std::string& text) {
        return std::isfinite(std::strtof(text.c_str(), nullptr))
                   ? std::string()
                   : "value " + text + " must be a finite number";
    },
    "");

void addRender(CLI::App& app, RenderOptions& options) {
    app.add_option("model", options.model, "model: .obj, .gltf, .glb or .ply")->required();
    app.add_option("-o,--output", options.output, "picture to write: .png, .jpg, .hdr or .exr")
        ->capture_default_str();
    app.add_option("--width", options.width, "pixels across")
        ->check(CLI::Range(1, 16384))
        ->capture_default_str();
    app.add_option("--height", options.height, "pixels down")
        ->check(CLI::Range(1, 16384))
        ->capture_default_str();
    app.add_option("--spp", options.samples, "samples for each pixel")
        ->check(CLI::Range(1, 1 << 20))
        ->capture_default_str();
    app.add_option("--bounces", options.bounces, "longest path")
        ->check(CLI::Range(0, 64))
        ->capture_default_str();
    app.add_option("--azimuth", options.azimuth, "camera's direction around the model, degrees")
        ->check(kFinite)
        ->check(CLI::Range(-360.0, 360.0))
        ->capture_default_str();
    app.add_option("--elevation", options.elevation, "camera's height above the horizon, degrees")
        ->check(kFinite)
        ->check(CLI::Range(-89.0, 89.0))
        ->capture_default_str();
    app.add_option("--zoom", options.zoom, "above 1: nearer")
        ->check(kFinite)
        ->check(CLI::Range(0.01, 100.0))
        ->capture_default_str();
    app.add_option("--camera", options.eye, "camera's position: X Y Z")
        ->check(kFinite)
        ->expected(3);
    app.add_option("--look-at", options.lookAt, "point in the middle of the picture: X Y Z")
        ->check(kFinite)
        ->expected(3);
    app.add_option("--fov", options.fov, "vertical angle of view for --camera, degrees")
        ->check(kFinite)
        ->check(CLI::Range(1.0, 170.0))
        ->capture_default_str();
    app.add_flag("!--no-ground", options.ground, "no floor under the model");
    app.add_flag("--z-up", options.zUp, "the model's z axis points up, not its y axis");
}

void addRun(CLI::App& app, RunOptions& options) {
    app.footer(
        "PROGRAM [ARGUMENTS...] follow the options.\n\n"
        "--check compiles device code (kernels and ray tracing programs) so that each load, "
        "store and atomic\nis checked before it is made: it must be aligned and lie within "
        "one allocation, the block's shared\nmemory, the parameters or the thread's own "
        "variables. Each violation is reported once for each place in the\nsource, with the "
        "address, the nearest allocation and the thread; the launch then fails with the "
        "documented\nerror. The exit code is 1 if anything was reported, else the "
        "program's.\n\n"
        "`mpirun -n N sunstone run PROGRAM` runs a program of the classic API on rank 0; the "
        "other ranks render\nsubframes of its progressive launches (docs/classic.md).");
    app.add_flag("--check", options.check, "check memory accesses of device code");
    app.add_flag("--leak-check", options.leakCheck,
                 "with --check: report device memory that is never freed");
    app.add_flag("--host-memory", options.hostMemory,
                 "with --check: device code may access ordinary memory of the process, "
                 "as the CPU can and a GPU cannot");
    app.add_option("--json", options.json, "with --check: write the reports to this file as JSON");
}

// `run` passes all words after the program's name to the program; CLI11 would parse its options.
int firstOfCommand(int argc, char** argv) {
    int i = 2;
    for (; i < argc; ++i) {
        const std::string word = argv[i];
        if (word == "--json")
            ++i;
        else if (word.rfind("-", 0) != 0 || word == "--")
            break;
    }
    return std::min(i, argc);
}

// CLI11 does not report unknown commands and options, because it first reports a missing command.
bool isUnknownCommand(const CLI::App& app, int argc, char** argv) {
    if (argc < 2)
        return false;
    const std::string word = argv[1];
    if (word.starts_with("-")) {
        if (app.get_option_no_throw(word))
            return false;
        std::fprintf(stderr, "sunstone: there is no option '%s' (see sunstone --help)\n",
                     word.c_str());
        return true;
    }
    std::string known;
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
        if (command->get_name() == word)
            return false;
        if (command->get_group().empty())
            continue; // not for people
        known += (known.empty() ? "" : ", ") + command->get_name();
    }
    std::fprintf(stderr, "sunstone: there is no command '%s'; commands: %s\n", word.c_str(),
                 known.c_str());
    return true;
}

} // namespace

int main(int argc, char** argv) {
    CLI::App app("Sunstone: OptiX programs on any machine.", "sunstone");
    app.require_subcommand(1);
    app.set_version_flag("--version", SUNSTONE_VERSION);

    bool infoJson = false;
    CLI::App* infoCommand =
        app.add_subcommand("info", "Show version, processor, libraries, settings");
    infoCommand->add_flag("--json", infoJson, "print JSON");

    RunOptions runOptions;
    CLI::App* runCommand = app.add_subcommand(
        "run", "Run a program with Sunstone's OptiX and CUDA libraries; its exit code is returned");
    addRun(*runCommand, runOptions);

    CLI::App* warmCommand = app.add_subcommand(
        "warm", "Fill the disk cache with the library's own kernels for the GPUs of this machine");

    int nodeSocket = -1;
    unsigned nodeDevice = 0;
    CLI::App* nodeCommand = app.add_subcommand("node", "What `run` starts on ranks above 0");
    nodeCommand->group(""); // not for people
    nodeCommand->add_option("socket", nodeSocket)->required();
    nodeCommand->add_option("device", nodeDevice)->required();

    CheckOptions checkOptions;
    CLI::App* checkCommand = app.add_subcommand("check", "Check a PTX file and list its programs");
    checkCommand->add_option("file", checkOptions.file, "PTX file")->required();
    checkCommand->add_option("--params", checkOptions.launchParams, "launch-parameter variable")
        ->capture_default_str();
    checkCommand->add_flag("--json", checkOptions.json, "print JSON");

    RenderOptions renderOptions;
    CLI::App* renderCommand = app.add_subcommand("render", "Path trace a model into a picture");
    addRender(*renderCommand, renderOptions);

    if (isUnknownCommand(app, argc, argv))
        return int(CLI::ExitCodes::ExtrasError);
    // `run` passes the program's words on; CLI11 would parse its options.
    const bool isRun = argc > 2 && std::string(argv[1]) == "run" &&
                       std::string(argv[2]) != "--help" && std::string(argv[2]) != "-h";
    const int first = isRun ? firstOfCommand(argc, argv) : argc;
    CLI11_PARSE(app, first, argv);
    const bool hasMark = first < argc && std::string(argv[first]) == "--";
    runOptions.command.assign(argv + first + (hasMark ? 1 : 0), argv + argc);
    try {
        if (*runCommand)
            return run(runOptions);
        if (*nodeCommand)
            return serveNode(nodeSocket, nodeDevice);
        if (*infoCommand)
            return info(infoJson);
        if (*warmCommand)
            return warm();
        if (*checkCommand)
            return check(checkOptions);
        return render(renderOptions);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "sunstone: %s\n", error.what());
        return 1;
    }
}
