// SPDX-License-Identifier: Apache-2.0
#include "hard_scenes.h"

#include <cmath>

namespace hard {
namespace {

int cell(float x) {
    return int(std::floor(x + 1e-3f));
}
float hashed(int x, int y, int z) {
    uint32_t h = uint32_t(x) * 0x9E3779B1u ^ uint32_t(y) * 0x85EBCA77u ^ uint32_t(z) * 0xC2B2AE3Du;
    h = (h ^ (h >> 15)) * 0x2C1B3C6Du;
    h = (h ^ (h >> 12)) * 0x297A2D39u;
    return float((h ^ (h >> 15)) >> 8) * 0x1p-24f;
}
bool isOdd(Vec p, float scale) {
    return (cell(p.x * scale) + cell(p.y * scale) + cell(p.z * scale)) & 1;
}
Vec grey(float value) {
    return {value, value, value};
}
Vec mix(Vec a, Vec b, float part) {
    return a * (1 - part) + b * part;
}

// ---- Textures -----------------------------------------------------------------------------------

Vec checks(Vec p) {
    return isOdd(p, 2) ? Vec{0.7f, 0.25f, 0.2f} : Vec{0.75f, 0.75f, 0.7f};
}
Vec darkChecks(Vec p) {
    return isOdd(p, 4) ? Vec{0.03f, 0.02f, 0.02f} : Vec{0.15f, 0.13f, 0.1f};
}
Vec darkGrain(Vec p) {
    return Vec{0.16f, 0.12f, 0.09f} * hashed(cell(p.x * 14), cell(p.y * 14), cell(p.z * 14));
}
Vec blackOnGrey(Vec p) { // soot: no reflectance in the cracks
    return isOdd(p, 3) ? grey(0.0f) : grey(0.08f);
}
Vec grain(Vec p) {
    const float value = hashed(cell(p.x * 10), cell(p.y * 10), cell(p.z * 10));
    return mix({0.2f, 0.3f, 0.15f}, {0.85f, 0.75f, 0.5f}, value);
}
Vec stripes(Vec p) {
    return cell(p.x * 8) & 1 ? grey(0.8f) : Vec{0.1f, 0.2f, 0.5f};
}
Vec waves(Vec p) {
    return grey(0.1f + 0.09f * std::sin(20 * p.x) * std::sin(20 * p.y + 3 * p.z));
}
Vec screenText(Vec p) {
    const bool lit = hashed(cell(p.x * 12), cell(p.y * 8), 5) > 0.6f;
    return lit ? Vec{1.6f, 2.0f, 1.2f} : Vec{0.02f, 0.05f, 0.08f};
}
Vec neon(Vec p) {
    return cell(p.x * 3) & 1 ? Vec{9, 1, 4} : Vec{0.5f, 2, 8};
}

// ---- Parts --------------------------------------------------------------------------------------

Material diffuse(Vec albedo) {
    Material material;
    material.albedo = albedo;
    return material;
}
Material textured(Texture texture) {
    Material material;
    material.texture = texture;
    return material;
}
Material mirror(Vec albedo, float roughness) {
    Material material = diffuse(albedo);
    material.isMirror = true;
    material.roughness = roughness;
    return material;
}
Material glowing(Vec emission) {
    Material material;
    material.emission = emission;
    return material;
}
Rectangle floorOf(const Material& material, float size = 8) {
    return {1, 0, {-size, -size}, {size, size}, material};
}
Rectangle wallBehind(const Material& material, float z = -2) {
    return {2, z, {-8, 0}, {8, 8}, material};
}
void addLamp(Scene& scene, Vec center, float radius, Vec emission) {
    scene.lamps.push_back({center, radius, glowing(emission)});
}
void addSky(Scene& scene, float strength) {
    scene.zenith = Vec{0.35f, 0.45f, 0.7f} * strength;
    scene.horizon = Vec{0.6f, 0.6f, 0.6f} * strength;
}
void addRoom(Scene& scene, const Material& left, const Material& right, const Material& rest) {
    scene.rectangles = {
        {1, 0, {-2, -2}, {2, 4.5f}, rest}, {1, 3, {-2, -2}, {2, 4.5f}, rest},
        {2, -2, {-2, 0}, {2, 3}, rest},    {2, 4.5f, {-2, 0}, {2, 3}, rest},
        {0, -2, {0, -2}, {3, 4.5f}, left}, {0, 2, {0, -2}, {3, 4.5f}, right},
    };
    scene.eye = {0, 1.5f, 4};
    scene.target = {0, 1.3f, 0};
}

// ---- Scenes -------------------------------------------------------------------------------------

Scene makeLampInView() { // small strong lamps before a wall
    Scene s{.name = "lamp"};
    s.rectangles = {floorOf(diffuse(grey(0.6f))), wallBehind(diffuse({0.6f, 0.5f, 0.4f}))};
    s.spheres = {{{-0.9f, 0.5f, 0}, 0.5f, diffuse({0.3f, 0.5f, 0.8f})}};
    addLamp(s, {0.5f, 1.2f, -0.6f}, 0.28f, grey(25));
    addLamp(s, {-1.1f, 1.7f, -1.2f}, 0.12f, {60, 40, 20});
    return s;
}
Scene makeDarkTextures() {
    Scene s{.name = "dark textures"};
    s.rectangles = {floorOf(textured(darkChecks)), wallBehind(textured(darkGrain))};
    s.spheres = {{{-0.8f, 0.6f, 0}, 0.6f, textured(waves)},
                 {{0.8f, 0.5f, 0.4f}, 0.5f, diffuse(grey(0.05f))}};
    addLamp(s, {1.5f, 4, 3}, 0.5f, grey(60));
    addSky(s, 0.5f);
    return s;
}
Scene makeSoot() { // black and nearly black before the sky
    Scene s{.name = "soot"};
    s.rectangles = {floorOf(textured(blackOnGrey))};
    s.spheres = {{{-0.6f, 0.7f, 0}, 0.7f, diffuse(grey(0.04f))},
                 {{0.9f, 0.5f, 0.3f}, 0.5f, textured(blackOnGrey)}};
    addSky(s, 1.5f);
    return s;
}
Scene makeHardShadows() { // small lamp, no guide shows the shadows
    Scene s{.name = "hard shadows"};
    s.rectangles = {floorOf(diffuse(grey(0.7f)))};
    for (int i = 0; i < 5; ++i)
        s.spheres.push_back({{-1.6f + 0.8f * float(i), 0.35f, i % 2 ? 0.5f : -0.4f},
                             0.3f,
                             diffuse({0.7f, 0.4f, 0.3f})});
    addLamp(s, {3, 4, 1}, 0.06f, grey(4000));
    addSky(s, 0.1f);
    return s;
}
Scene makeFence() { // bars about a pixel wide
    Scene s{.name = "fence"};
    s.rectangles = {floorOf(textured(checks)), wallBehind(diffuse(grey(0.7f)))};
    for (int i = 0; i < 14; ++i) {
        const float x = -2.0f + 0.3f * float(i);
        s.rectangles.push_back({2, 0.4f, {x, 0}, {x + 0.04f, 1.1f}, diffuse(grey(0.05f))});
    }
    s.rectangles.push_back({2, 0.4f, {-2, 0.8f}, {2, 0.84f}, diffuse(grey(0.05f))});
    addLamp(s, {-2, 4, 3}, 0.8f, grey(25));
    addSky(s, 0.3f);
    return s;
}
Scene makeGrain() { // textures everywhere, light of the sky alone
    Scene s{.name = "grain"};
    s.rectangles = {floorOf(textured(grain)), wallBehind(textured(stripes), -3)};
    s.spheres = {{{-0.8f, 0.7f, 0}, 0.7f, textured(checks)},
                 {{0.8f, 0.5f, 0.5f}, 0.5f, textured(grain)}};
    addSky(s, 1.2f);
    return s;
}
Scene makeScreen() { // a glowing pattern: albedo 0 throughout
    Scene s{.name = "screen"};
    Material screen;
    screen.glow = screenText;
    s.rectangles = {floorOf(diffuse(grey(0.4f))),
                    {2, -0.5f, {-1.3f, 0.3f}, {1.3f, 1.7f}, screen},
                    wallBehind(diffuse(grey(0.15f)))};
    addSky(s, 0.1f);
    return s;
}
Scene makeMirrors() {
    Scene s{.name = "mirrors"};
    s.rectangles = {floorOf(textured(stripes)), wallBehind(diffuse({0.5f, 0.6f, 0.5f}))};
    s.spheres = {{{-0.9f, 0.6f, 0}, 0.6f, mirror(grey(0.9f), 0)},
                 {{0.5f, 0.5f, 0.4f}, 0.5f, mirror({0.9f, 0.7f, 0.4f}, 0.15f)},
                 {{1.4f, 0.4f, -0.3f}, 0.4f, mirror(grey(0.5f), 0.4f)}};
    addLamp(s, {-1, 3.5f, 2}, 0.5f, grey(30));
    addSky(s, 0.3f);
    return s;
}
Scene makeByChance() { // a closed room whose lamp paths find by chance
    Scene s{.name = "by chance"};
    addRoom(s, diffuse({0.7f, 0.2f, 0.15f}), diffuse({0.2f, 0.6f, 0.2f}), diffuse(grey(0.7f)));
    s.spheres = {{{-0.8f, 0.6f, -0.6f}, 0.6f, diffuse(grey(0.7f))},
                 {{0.8f, 0.5f, 0.2f}, 0.5f, textured(checks)}};
    addLamp(s, {0.2f, 2.3f, -0.4f}, 0.35f, {18, 15, 10});
    s.lightByChance = true;
    s.depth = 5;
    return s;
}
Scene makeDepthOfField() { // every guide is blurred
    Scene s{.name = "depth of field"};
    s.rectangles = {floorOf(textured(checks)), wallBehind(textured(stripes), -4)};
    s.spheres = {{{-0.9f, 0.5f, 1.4f}, 0.5f, diffuse({0.8f, 0.3f, 0.2f})},
                 {{0.3f, 0.6f, 0}, 0.6f, textured(darkChecks)},
                 {{1.6f, 0.8f, -2}, 0.8f, diffuse({0.3f, 0.6f, 0.3f})}};
    addLamp(s, {1.2f, 2.0f, -3}, 0.12f, grey(80));
    addLamp(s, {-1, 4, 3}, 0.6f, grey(25));
    s.aperture = 0.12f;
    addSky(s, 0.2f);
    return s;
}
Scene makeBacklight() { // dark objects before a bright sky
    Scene s{.name = "backlight"};
    s.rectangles = {floorOf(textured(darkGrain), 4)};
    s.spheres = {{{-0.7f, 0.8f, 0}, 0.6f, diffuse({0.5f, 0.1f, 0.1f})},
                 {{0.7f, 0.9f, -0.5f}, 0.5f, diffuse({0.1f, 0.1f, 0.12f})},
                 {{0.2f, 1.6f, 0.3f}, 0.15f, diffuse(grey(0.8f))}};
    addSky(s, 5);
    s.eye = {0, 0.7f, 4};
    s.target = {0, 0.9f, 0};
    return s;
}
Scene makeFaintLight() { // almost dark, with one bright object at its edge
    Scene s{.name = "faint light"};
    addRoom(s, diffuse(grey(0.5f)), textured(waves), textured(grain));
    s.spheres = {{{0.7f, 0.5f, 0}, 0.5f, diffuse({0.2f, 0.3f, 0.7f})}};
    addLamp(s, {-1.6f, 0.4f, 0.5f}, 0.08f, {30, 16, 6});
    return s;
}

// The held-out scenes, on which no constant was chosen.
Scene makeNeon() {
    Scene s{.name = "neon"};
    Material tube;
    tube.glow = neon;
    s.rectangles = {floorOf(textured(darkGrain)),
                    wallBehind(textured(checks)),
                    {2, -1.9f, {-1.5f, 1.3f}, {1.5f, 1.42f}, tube},
                    {2, -1.9f, {-1.5f, 0.5f}, {1.5f, 0.53f}, tube}};
    s.spheres = {{{0.6f, 0.5f, 0.2f}, 0.5f, mirror(grey(0.8f), 0.05f)}};
    addSky(s, 0.05f);
    return s;
}
Scene makeGate() {
    Scene s{.name = "gate"};
    s.rectangles = {floorOf(textured(waves))};
    for (int i = 0; i < 10; ++i) {
        const float x = -1.6f + 0.35f * float(i);
        s.rectangles.push_back({2, 0.8f, {x, 0}, {x + 0.07f, 1.4f}, diffuse({0.6f, 0.5f, 0.1f})});
    }
    s.spheres = {{{0.1f, 0.6f, -0.6f}, 0.6f, diffuse(grey(0.02f))}};
    addLamp(s, {2, 2.5f, -3}, 0.15f, grey(700));
    addSky(s, 0.8f);
    return s;
}
Scene makeWhiteRoom() {
    Scene s{.name = "white room"};
    addRoom(s, diffuse(grey(0.85f)), diffuse(grey(0.85f)), diffuse(grey(0.85f)));
    s.spheres = {{{-0.7f, 0.5f, 0}, 0.5f, diffuse({0.9f, 0.5f, 0.5f})},
                 {{0.8f, 0.7f, -0.7f}, 0.7f, mirror(grey(0.95f), 0)}};
    addLamp(s, {0, 2.7f, 0}, 0.2f, grey(60));
    s.depth = 6;
    return s;
}
Scene makeStreetAtNight() {
    Scene s{.name = "street at night"};
    s.rectangles = {floorOf(textured(darkChecks)),
                    {0, -1.6f, {0, -6}, {3, 3}, textured(grain)},
                    {0, 1.6f, {0, -6}, {3, 3}, diffuse({0.25f, 0.2f, 0.2f})}};
    s.spheres = {{{0.3f, 0.4f, 0.8f}, 0.4f, diffuse({0.08f, 0.02f, 0.02f})}};
    for (int i = 0; i < 4; ++i)
        addLamp(s, {i % 2 ? 1.2f : -1.2f, 1.8f, 1.0f - 1.6f * float(i)}, 0.09f, {90, 70, 40});
    addSky(s, 0.02f);
    return s;
}

} // namespace

Scene makeScene(unsigned number) {
    using Make = Scene (*)();
    static const Make kMakers[kSceneCount] = {
        makeLampInView, makeDarkTextures, makeSoot,      makeHardShadows,
        makeFence,      makeGrain,        makeScreen,    makeMirrors,
        makeByChance,   makeDepthOfField, makeBacklight, makeFaintLight,
        makeNeon,       makeGate,         makeWhiteRoom, makeStreetAtNight,
    };
    return kMakers[number]();
}

} // namespace hard
