// SPDX-License-Identifier: Apache-2.0
// A renderer with shader graphs: nodes are records with ids of callable programs, which call each
// other by id, read variables of their own scope, and trace rays whose closest-hit programs
// evaluate graphs again. Bound callables, ids in variables and buffers, and a marked call site are
// used.
#include "device/node_graph.h"
#include "common.h"

#include <optixu/optixu_math_namespace.h>

#include <cmath>
#include <functional>
#include <vector>

using namespace optix;

namespace {

constexpr int kLayers = 3;
enum Kind { kConstant, kSum, kProduct, kLook, kEvaluate, kKinds };

class Renderer {
public:
    Renderer() {
        context_ = Context::create();
        context_->setRayTypeCount(1);
        context_->setEntryPointCount(1);
        context_->setMaxTraceDepth(6);
        context_->setMaxCallableProgramDepth(12);
        context_->setRayGenerationProgram(0, program("start"));
        context_->setMissProgram(0, program("end"));
        results_ = context_->createBuffer(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT, 8);
        context_["results"]->set(results_);
        context_["gain"]->setFloat(1);
        const char* const names[kKinds] = {"constant", "sum", "product", "look", "evaluate_marked"};
        Buffer functions = context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_PROGRAM_ID, kKinds);
        for (int i = 0; i < kKinds; ++i)
            functions_[i] = program(names[i]);
        functions_[kConstant]["gain"]->setFloat(gain_);
        auto* ids = static_cast<int*>(functions->map());
        for (int i = 0; i < kKinds; ++i)
            ids[i] = functions_[i]->getId();
        functions->unmap();
        context_["functions"]->set(functions);
        tones_[0] = program("plain_tone");
        tones_[1] = program("double_tone");
        makeLayers();
    }
    ~Renderer() { context_->destroy(); }
    Renderer(const Renderer&) = delete;

    void setGraph(const std::vector<Node>& nodes) {
        nodes_ = nodes;
        Buffer buffer = context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_USER, nodes.size());
        buffer->setElementSize(sizeof(Node));
        auto* to = static_cast<Node*>(buffer->map());
        for (const Node& node : nodes) {
            *to = node;
            to++->function = functions_[node.function]->getId();
        }
        buffer->unmap();
        context_["nodes"]->set(buffer);
        context_["root"]->setInt(int(nodes.size()) - 1);
    }
    void setTone(int tone) {
        context_["tone"]->set(tones_[tone]);
        tone_ = tone;
    }
    void check(const std::string& what) {
        context_["evaluator"]->setInt(functions_[kEvaluate]->getId());
        context_["surface_function"]->setProgramId(functions_[nodes_.back().function]);
        std::vector<int> callees;
        for (const Program& each : functions_)
            callees.push_back(each->getId());
        shade_->setCallsitePotentialCallees("shade", callees);
        context_->validate();
        context_->launch(0, 8);
        float wanted = shade(0, 0);
        if (tone_)
            wanted = 2 * wanted + 1;
        const auto* values = static_cast<const float*>(results_->map());
        for (int i = 0; i < 8; ++i)
            require(std::fabs(values[i] - wanted) <= 1e-5f * std::fabs(wanted),
                    what + ": " + std::to_string(values[i]) + " in place of " +
                        std::to_string(wanted));
        results_->unmap();
    }

private:
    Program program(const char* name) {
        return context_->createProgramFromPTXString(device_ptx, name);
    }
    void makeLayers() {
        Geometry geometry = context_->createGeometry();
        geometry->setPrimitiveCount(kLayers);
        geometry->setBoundingBoxProgram(program("layer_bounds"));
        geometry->setIntersectionProgram(program("layer_intersect"));
        Material material = context_->createMaterial();
        shade_ = program("shade");
        material->setClosestHitProgram(0, shade_);
        GeometryGroup group = context_->createGeometryGroup();
        group->addChild(context_->createGeometryInstance(geometry, &material, &material + 1));
        group->setAcceleration(context_->createAcceleration("Trbvh"));
        context_["world"]->set(group);
    }
    // As the device does it: `depth` is the payload's.
    float evaluate(int node, float x, int layer, int depth) const {
        if (node < 0)
            return x;
        const Node& n = nodes_[size_t(node)];
        switch (n.function) {
        case kConstant:
            return n.constant * gain_;
        case kSum:
            return evaluate(n.left, x, layer, depth) + evaluate(n.right, x, layer, depth);
        case kProduct:
            return evaluate(n.left, x, layer, depth) * evaluate(n.right, x, layer, depth);
        default:
            return depth + 1 > 3 ? 100 : shade(layer + 1, depth + 1) + x * n.constant;
        }
    }
    float shade(int layer, int depth) const {
        if (layer >= kLayers)
            return 1000;
        const int root = int(nodes_.size()) - 1;
        return evaluate(root, float(layer), layer, depth) + evaluate(root, 1, layer, depth);
    }

    Context context_;
    Buffer results_;
    Program functions_[kKinds], tones_[2], shade_;
    std::vector<Node> nodes_;
    const float gain_ = 3;
    int tone_ = 0;
};

void run() {
    Renderer renderer;
    renderer.setTone(0);
    renderer.setGraph({{kConstant, 0, 0, 2.5f}});
    renderer.check("a constant");
    renderer.setGraph({{kConstant, 0, 0, 0.5f}, {kSum, 0, -1, 0}, {kProduct, 1, 1, 0}});
    renderer.check("a square");
    renderer.setTone(1);
    renderer.check("a square in another tone");
    renderer.setGraph(
        {{kConstant, 0, 0, 0.25f}, {kLook, 0, 0, 2}, {kProduct, 0, 1, 0}, {kSum, 2, -1, 0}});
    renderer.check("a graph that looks");
    renderer.setTone(0);
    renderer.setGraph({{kLook, 0, 0, 0.5f}});
    renderer.check("rays alone");
    renderer.setGraph({{kConstant, 0, 0, -1}});
    renderer.check("a constant again");
}

} // namespace

int main() {
    return runProgram(run);
}
