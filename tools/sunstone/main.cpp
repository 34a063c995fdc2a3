// SPDX-License-Identifier: Apache-2.0
// The command `sunstone`: about this installation, programs run with it, PTX checked, models
// rendered.
#include "commands.h"

#include <CLI/CLI.hpp>

#include <cstdio>

using namespace sunstone::tool;

namespace {

void addRender(CLI::App& app, RenderOptions& options) {
    app.add_option("model", options.model, "model: .obj, .gltf, .glb or .ply")->required();
    app.add_option("-o,--output", options.output, "picture to write, PNG")->capture_default_str();
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
        ->check(CLI::Range(-360.0, 360.0))
        ->capture_default_str();
    app.add_option("--elevation", options.elevation, "camera's height above the horizon, degrees")
        ->check(CLI::Range(-89.0, 89.0))
        ->capture_default_str();
    app.add_option("--zoom", options.zoom, "above 1: nearer")
        ->check(CLI::Range(0.01, 100.0))
        ->capture_default_str();
    app.add_option("--camera", options.eye, "camera's position: X Y Z")->expected(3);
    app.add_option("--look-at", options.lookAt, "point in the middle of the picture: X Y Z")
        ->expected(3);
    app.add_option("--fov", options.fov, "vertical angle of view for --camera, degrees")
        ->check(CLI::Range(1.0, 170.0))
        ->capture_default_str();
    app.add_flag("!--no-ground", options.ground, "no floor under the model");
    app.add_flag("--z-up", options.zUp, "the model's z axis points up, not its y axis");
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

    std::vector<std::string> command;
    CLI::App* runCommand = app.add_subcommand(
        "run", "Run a program with Sunstone's OptiX and CUDA libraries; its exit code is returned");
    runCommand->add_option("command", command, "program and its arguments (after --)")->required();
    runCommand->prefix_command(); // options behind the program belong to it
    runCommand->positionals_at_end();

    CheckOptions checkOptions;
    CLI::App* checkCommand = app.add_subcommand("check", "Check a PTX file and list its programs");
    checkCommand->add_option("file", checkOptions.file, "PTX file")->required();
    checkCommand->add_option("--params", checkOptions.launchParams, "launch-parameter variable")
        ->capture_default_str();
    checkCommand->add_flag("--json", checkOptions.json, "print JSON");

    RenderOptions renderOptions;
    CLI::App* renderCommand = app.add_subcommand("render", "Path trace a model into a PNG picture");
    addRender(*renderCommand, renderOptions);

    // `run` hands everything behind it to the program; CLI11 would claim what looks like options.
    bool isRun = argc > 2 && std::string(argv[1]) == "run" && std::string(argv[2]) != "--help" &&
                 std::string(argv[2]) != "-h";
    if (isRun) {
        int first = std::string(argv[2]) == "--" ? 3 : 2;
        command.assign(argv + first, argv + argc);
    } else {
        CLI11_PARSE(app, argc, argv);
    }
    try {
        if (isRun || *runCommand)
            return run(command);
        if (*infoCommand)
            return info(infoJson);
        if (*checkCommand)
            return check(checkOptions);
        return render(renderOptions);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "sunstone: %s\n", error.what());
        return 1;
    }
}
