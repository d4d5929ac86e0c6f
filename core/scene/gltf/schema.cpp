#include "core/scene/gltf/schema.h"

namespace photond::gltf {
namespace {

using Kind = Schema::Kind;

constexpr double kMaxIndex = 2'147'483'647.0;         // the parser keeps indices in int
constexpr double kMaxSize = 9'007'199'254'740'992.0;  // 2^53

constexpr Schema kBoolean{.kind = Kind::boolean};
constexpr Schema kString{.kind = Kind::string};
constexpr Schema kNumber{.kind = Kind::number};
constexpr Schema kUnit{.kind = Kind::number, .min = 0, .max = 1};
constexpr Schema kNonNegative{.kind = Kind::number, .min = 0};
constexpr Schema kExtensionNumber{.kind = Kind::number, .narrow_integers = true};
constexpr Schema kExtensionNonNegative{.kind = Kind::number, .min = 0, .narrow_integers = true};
constexpr Schema kIndex{.kind = Kind::integer, .min = 0, .max = kMaxIndex};
constexpr Schema kSize{.kind = Kind::integer, .min = 0, .max = kMaxSize};
constexpr Schema kLength{.kind = Kind::integer, .min = 1, .max = kMaxSize};
constexpr Schema kCount{.kind = Kind::integer, .min = 1, .max = kMaxIndex};
constexpr Schema kObject{.kind = Kind::object};
constexpr Schema kObjects{.kind = Kind::array, .items = &kObject};
constexpr Schema kNumbers{.kind = Kind::array, .items = &kNumber};
constexpr Schema kIndices{.kind = Kind::array, .items = &kIndex};
constexpr Schema kStrings{.kind = Kind::array, .items = &kString};
constexpr Schema kIndexMap{.kind = Kind::object, .others = &kIndex};
constexpr Schema kIndexMaps{.kind = Kind::array, .items = &kIndexMap};

constexpr Schema numbers(std::size_t n, const Schema& item = kNumber) {
  return {.kind = Kind::array, .items = &item, .min_items = n, .max_items = n};
}
constexpr Schema object(std::span<const Field> fields) { return {.kind = Kind::object, .fields = fields}; }
constexpr Schema extensions(std::span<const Field> fields) {
  return {.kind = Kind::object, .fields = fields, .others = &kObject};
}
constexpr Schema list(const Schema& item) { return {.kind = Kind::array, .items = &item}; }

constexpr Schema kVec3 = numbers(3), kVec4 = numbers(4), kMatrix = numbers(16);
constexpr Schema kExtensionVec2 = numbers(2, kExtensionNumber);
constexpr Schema kUnitVec3 = numbers(3, kUnit), kUnitVec4 = numbers(4, kUnit);
constexpr Schema kColor3 = numbers(3, kNonNegative), kExtensionColor3 = numbers(3, kExtensionNonNegative);

// asset, buffers, views, accessors
constexpr Field kAssetFields[] = {{"version", &kString, true},
                                  {"minVersion", &kString},
                                  {"generator", &kString},
                                  {"copyright", &kString},
                                  {"extensions", &kObject}};
constexpr Schema kAsset = object(kAssetFields);
constexpr Schema kBufferUri{.kind = Kind::string, .role = Role::buffer_uri};
constexpr Schema kBufferLength{.kind = Kind::integer, .role = Role::buffer_length, .min = 1, .max = kMaxSize};
constexpr Schema kFallback{.kind = Kind::boolean, .role = Role::buffer_fallback};
constexpr Field kFallbackFields[] = {{"fallback", &kFallback}};
constexpr Schema kFallbackBuffer = object(kFallbackFields);
constexpr Field kBufferExtensionFields[] = {{"EXT_meshopt_compression", &kFallbackBuffer}};
constexpr Schema kBufferExtensions = extensions(kBufferExtensionFields);
constexpr Field kBufferFields[] = {{"uri", &kBufferUri},
                                   {"byteLength", &kBufferLength, true},
                                   {"name", &kString},
                                   {"extensions", &kBufferExtensions}};
constexpr Schema kBuffer{.kind = Kind::object, .role = Role::buffer, .fields = kBufferFields};
constexpr Field kMeshoptFields[] = {
    {"buffer", &kIndex, true}, {"byteOffset", &kIndex},  {"byteLength", &kCount, true}, {"byteStride", &kCount, true},
    {"count", &kCount, true},  {"mode", &kString, true}, {"filter", &kString}};
constexpr Schema kMeshopt{.kind = Kind::object, .role = Role::meshopt, .fields = kMeshoptFields};
constexpr Field kViewExtensionFields[] = {{"EXT_meshopt_compression", &kMeshopt}};
constexpr Schema kViewExtensions = extensions(kViewExtensionFields);
constexpr Field kViewFields[] = {
    {"buffer", &kIndex, true}, {"byteOffset", &kSize}, {"byteLength", &kLength, true},   {"byteStride", &kSize},
    {"target", &kIndex},       {"name", &kString},     {"extensions", &kViewExtensions}};
constexpr Schema kView = object(kViewFields);
constexpr Field kSparseIndicesFields[] = {
    {"bufferView", &kIndex, true}, {"byteOffset", &kIndex}, {"componentType", &kIndex, true}};
constexpr Schema kSparseIndices = object(kSparseIndicesFields);
constexpr Field kSparseValuesFields[] = {{"bufferView", &kIndex, true}, {"byteOffset", &kIndex}};
constexpr Schema kSparseValues = object(kSparseValuesFields);
constexpr Field kSparseFields[] = {
    {"count", &kCount, true}, {"indices", &kSparseIndices, true}, {"values", &kSparseValues, true}};
constexpr Schema kSparse = object(kSparseFields);
constexpr Field kAccessorFields[] = {{"bufferView", &kIndex},   {"byteOffset", &kSize},
                                     {"normalized", &kBoolean}, {"componentType", &kIndex, true},
                                     {"count", &kLength, true}, {"type", &kString, true},
                                     {"min", &kNumbers},        {"max", &kNumbers},
                                     {"sparse", &kSparse},      {"name", &kString},
                                     {"extensions", &kObject}};
constexpr Schema kAccessor = object(kAccessorFields);

// images, samplers, textures
constexpr Field kImageFields[] = {{"uri", &kString},
                                  {"bufferView", &kIndex},
                                  {"mimeType", &kString},
                                  {"name", &kString},
                                  {"extensions", &kObject}};
constexpr Schema kImage = object(kImageFields);
constexpr Field kSamplerFields[] = {
    {"magFilter", &kIndex}, {"minFilter", &kIndex}, {"wrapS", &kIndex}, {"wrapT", &kIndex}, {"name", &kString}};
constexpr Schema kSampler = object(kSamplerFields);
constexpr Field kSourceFields[] = {{"source", &kIndex}};
constexpr Schema kSource = object(kSourceFields);
constexpr Field kTextureExtensionFields[] = {{"EXT_texture_webp", &kSource}};
constexpr Schema kTextureExtensions = object(kTextureExtensionFields);
constexpr Field kTextureFields[] = {
    {"sampler", &kIndex}, {"source", &kIndex}, {"name", &kString}, {"extensions", &kTextureExtensions}};
constexpr Schema kTexture = object(kTextureFields);

// materials
constexpr Field kTransformFields[] = {
    {"offset", &kExtensionVec2}, {"scale", &kExtensionVec2}, {"rotation", &kExtensionNumber}, {"texCoord", &kIndex}};
constexpr Schema kTransform = object(kTransformFields);
constexpr Field kInfoExtensionFields[] = {{"KHR_texture_transform", &kTransform}};
constexpr Schema kInfoExtensions = object(kInfoExtensionFields);
constexpr Field kInfoFields[] = {{"index", &kIndex, true},
                                 {"texCoord", &kIndex},
                                 {"scale", &kNumber},
                                 {"strength", &kUnit},
                                 {"extensions", &kInfoExtensions}};
constexpr Schema kInfo = object(kInfoFields);
constexpr Field kPbrFields[] = {{"baseColorFactor", &kUnitVec4},
                                {"baseColorTexture", &kInfo},
                                {"metallicFactor", &kUnit},
                                {"roughnessFactor", &kUnit},
                                {"metallicRoughnessTexture", &kInfo}};
constexpr Schema kPbr = object(kPbrFields);
constexpr Field kStrengthFields[] = {{"emissiveStrength", &kExtensionNonNegative}};
constexpr Schema kStrength = object(kStrengthFields);
constexpr Field kIorFields[] = {{"ior", &kExtensionNonNegative}};
constexpr Schema kIor = object(kIorFields);
constexpr Field kSpecularFields[] = {{"specularFactor", &kUnit},
                                     {"specularTexture", &kInfo},
                                     {"specularColorFactor", &kExtensionColor3},
                                     {"specularColorTexture", &kInfo}};
constexpr Schema kSpecular = object(kSpecularFields);
constexpr Field kTransmissionFields[] = {{"transmissionFactor", &kUnit}, {"transmissionTexture", &kInfo}};
constexpr Schema kTransmission = object(kTransmissionFields);
constexpr Field kDispersionFields[] = {{"dispersion", &kExtensionNonNegative}};
constexpr Schema kDispersion = object(kDispersionFields);
constexpr Field kVolumeFields[] = {{"thicknessFactor", &kExtensionNonNegative},
                                   {"thicknessTexture", &kInfo},
                                   {"attenuationDistance", &kExtensionNonNegative},
                                   {"attenuationColor", &kUnitVec3}};
constexpr Schema kVolume = object(kVolumeFields);
constexpr Field kAnisotropyFields[] = {{"anisotropyStrength", &kUnit},
                                       {"anisotropyRotation", &kExtensionNumber},
                                       {"anisotropyTexture", &kInfo}};
constexpr Schema kAnisotropy = object(kAnisotropyFields);
constexpr Field kClearcoatFields[] = {{"clearcoatFactor", &kUnit},
                                      {"clearcoatTexture", &kInfo},
                                      {"clearcoatRoughnessFactor", &kUnit},
                                      {"clearcoatRoughnessTexture", &kInfo},
                                      {"clearcoatNormalTexture", &kInfo}};
constexpr Schema kClearcoat = object(kClearcoatFields);
constexpr Field kSheenFields[] = {{"sheenColorFactor", &kUnitVec3},
                                  {"sheenColorTexture", &kInfo},
                                  {"sheenRoughnessFactor", &kUnit},
                                  {"sheenRoughnessTexture", &kInfo}};
constexpr Schema kSheen = object(kSheenFields);
constexpr Field kMaterialExtensionFields[] = {{"KHR_materials_anisotropy", &kAnisotropy},
                                              {"KHR_materials_clearcoat", &kClearcoat},
                                              {"KHR_materials_dispersion", &kDispersion},
                                              {"KHR_materials_emissive_strength", &kStrength},
                                              {"KHR_materials_ior", &kIor},
                                              {"KHR_materials_sheen", &kSheen},
                                              {"KHR_materials_specular", &kSpecular},
                                              {"KHR_materials_transmission", &kTransmission},
                                              {"KHR_materials_volume", &kVolume},
                                              {"KHR_materials_unlit", &kObject}};
constexpr Schema kMaterialExtensions = extensions(kMaterialExtensionFields);
constexpr Field kMaterialFields[] = {{"name", &kString},          {"pbrMetallicRoughness", &kPbr},
                                     {"normalTexture", &kInfo},   {"occlusionTexture", &kInfo},
                                     {"emissiveTexture", &kInfo}, {"emissiveFactor", &kUnitVec3},
                                     {"alphaMode", &kString},     {"alphaCutoff", &kNonNegative},
                                     {"doubleSided", &kBoolean},  {"extensions", &kMaterialExtensions}};
constexpr Schema kMaterial = object(kMaterialFields);

// meshes
constexpr Field kDracoFields[] = {{"bufferView", &kIndex, true}, {"attributes", &kIndexMap, true}};
constexpr Schema kDraco{.kind = Kind::object, .role = Role::draco, .fields = kDracoFields};
constexpr Field kPrimitiveExtensionFields[] = {{"KHR_draco_mesh_compression", &kDraco}};
constexpr Schema kPrimitiveExtensions = extensions(kPrimitiveExtensionFields);
constexpr Field kPrimitiveFields[] = {
    {"attributes", &kIndexMap, true}, {"indices", &kIndex},    {"material", &kIndex}, {"mode", &kIndex},
    {"targets", &kIndexMaps},         {"extensions", &kPrimitiveExtensions}};
constexpr Schema kPrimitive = object(kPrimitiveFields);
constexpr Schema kPrimitives{.kind = Kind::array, .items = &kPrimitive, .min_items = 1};
constexpr Field kMeshFields[] = {
    {"primitives", &kPrimitives, true}, {"weights", &kNumbers}, {"name", &kString}, {"extensions", &kObject}};
constexpr Schema kMesh = object(kMeshFields);

// cameras and lights
constexpr Field kPerspectiveFields[] = {{"aspectRatio", &kNonNegative},
                                        {"yfov", &kNonNegative, true},
                                        {"zfar", &kNonNegative},
                                        {"znear", &kNonNegative, true}};
constexpr Schema kPerspective = object(kPerspectiveFields);
constexpr Field kOrthographicFields[] = {{"xmag", &kNumber, true},
                                         {"ymag", &kNumber, true},
                                         {"zfar", &kNonNegative, true},
                                         {"znear", &kNonNegative, true}};
constexpr Schema kOrthographic = object(kOrthographicFields);
constexpr Field kCameraFields[] = {{"type", &kString, true},
                                   {"perspective", &kPerspective},
                                   {"orthographic", &kOrthographic},
                                   {"name", &kString},
                                   {"extensions", &kObject}};
constexpr Schema kCamera = object(kCameraFields);
constexpr Field kSpotFields[] = {{"innerConeAngle", &kNonNegative}, {"outerConeAngle", &kNonNegative}};
constexpr Schema kSpot = object(kSpotFields);
constexpr Field kLightFields[] = {{"type", &kString, true}, {"color", &kColor3}, {"intensity", &kNonNegative},
                                  {"range", &kNonNegative}, {"spot", &kSpot},    {"name", &kString},
                                  {"extensions", &kObject}};
constexpr Schema kLight = object(kLightFields);
constexpr Schema kLights = list(kLight);
constexpr Field kLightsFields[] = {{"lights", &kLights, true}};
constexpr Schema kLightsPunctual = object(kLightsFields);

// nodes, skins and scenes
constexpr Field kLightReferenceFields[] = {{"light", &kIndex, true}};
constexpr Schema kLightReference = object(kLightReferenceFields);
constexpr Field kInstancingFields[] = {{"attributes", &kIndexMap, true}};
constexpr Schema kInstancing = object(kInstancingFields);
constexpr Field kNodeExtensionFields[] = {{"KHR_lights_punctual", &kLightReference},
                                          {"EXT_mesh_gpu_instancing", &kInstancing}};
constexpr Schema kNodeExtensions = extensions(kNodeExtensionFields);
constexpr Field kNodeFields[] = {{"name", &kString},
                                 {"camera", &kIndex},
                                 {"mesh", &kIndex},
                                 {"skin", &kIndex},
                                 {"children", &kIndices},
                                 {"matrix", &kMatrix},
                                 {"translation", &kVec3},
                                 {"rotation", &kVec4},
                                 {"scale", &kVec3},
                                 {"weights", &kNumbers},
                                 {"extensions", &kNodeExtensions}};
constexpr Schema kNode{.kind = Kind::object, .role = Role::node, .fields = kNodeFields};
constexpr Schema kJoints{.kind = Kind::array, .items = &kIndex, .min_items = 1};
constexpr Field kSkinFields[] = {{"joints", &kJoints, true}, {"inverseBindMatrices", &kIndex},
                                 {"skeleton", &kIndex},      {"name", &kString},
                                 {"extensions", &kObject}};
constexpr Schema kSkin = object(kSkinFields);
constexpr Field kSceneFields[] = {{"nodes", &kIndices}, {"name", &kString}, {"extensions", &kObject}};
constexpr Schema kScene = object(kSceneFields);
constexpr Field kRootExtensionFields[] = {{"KHR_lights_punctual", &kLightsPunctual}};
constexpr Schema kRootExtensions = object(kRootExtensionFields);

constexpr Schema kRequired{.kind = Kind::string, .role = Role::extension_required};
constexpr Schema kRequiredList = list(kRequired);
constexpr Schema kBuffers = list(kBuffer), kViews = list(kView), kAccessors = list(kAccessor),
                 kImages = list(kImage), kSamplers = list(kSampler), kTextures = list(kTexture),
                 kMaterials = list(kMaterial), kMeshes = list(kMesh), kCameras = list(kCamera),
                 kNodes = list(kNode), kSkins = list(kSkin), kScenes = list(kScene);
constexpr Field kRootFields[] = {{"asset", &kAsset, true},      {"scene", &kIndex},
                                 {"extensionsUsed", &kStrings}, {"extensionsRequired", &kRequiredList},
                                 {"buffers", &kBuffers},        {"bufferViews", &kViews},
                                 {"accessors", &kAccessors},    {"images", &kImages},
                                 {"samplers", &kSamplers},      {"textures", &kTextures},
                                 {"materials", &kMaterials},    {"meshes", &kMeshes},
                                 {"cameras", &kCameras},        {"nodes", &kNodes},
                                 {"scenes", &kScenes},          {"skins", &kSkins},
                                 {"animations", &kObjects},     {"extensions", &kRootExtensions}};
constexpr Schema kRoot = object(kRootFields);

}  // namespace

const Schema& gltf_schema() { return kRoot; }

}  // namespace photond::gltf
