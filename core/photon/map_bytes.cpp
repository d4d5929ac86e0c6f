#include "core/photon/map_bytes.h"

#include <cstring>

#include "core/photon/photon_stage.h"

namespace photond {

namespace {

// Raised with every change of what the sections are.
constexpr std::uint32_t kVersion = 5;

// What stands in a file beside arrays.
struct MapsHead {
  PhotonMap::Head global;
  PhotonMap::Head caustic;
  PhotonMap::Head irradiance;
  float irradiance_reach;
  double emitted;
  std::uint64_t rays;
  std::uint64_t caustic_rays;
  EnergyLedger ledger;
  double build_seconds;
};
static_assert(sizeof(MapsHead) == 3 * 36 + 4 + 8 + 2 * 8 + sizeof(EnergyLedger) + 8, "no padding");
static_assert(kFactsBytes == Sections::kHeadBytes + sizeof(MapsHead));

// Sections of photon maps: the head, then leaves, étendues and tree of each map. Irradiance's or a guide's follow them.
constexpr std::size_t kMapSections = 3;
constexpr std::size_t kMapsSections = 1 + 2 * kMapSections;

void add_map(const PhotonMap& map, SectionList& list) {
  list.add(map.leaves());
  list.add(map.etendues());
  list.add(map.tree().nodes());
}

SectionList sections_of(const PhotonMaps& maps, double build_seconds) {
  SectionList list;
  list.add_value(MapsHead{.global = maps.global.head(),
                          .caustic = maps.caustic.head(),
                          .irradiance = maps.irradiance.places().head(),
                          .irradiance_reach = maps.irradiance.reach(),
                          .emitted = maps.emitted,
                          .rays = maps.rays,
                          .caustic_rays = maps.caustic_rays,
                          .ledger = maps.ledger,
                          .build_seconds = build_seconds});
  add_map(maps.global, list);
  add_map(maps.caustic, list);
  return list;
}

std::optional<PhotonMap> map_at(const Sections& sections, std::size_t first, const PhotonMap::Head& head) {
  const auto leaves = sections.get<PhotonLeaf>(first);
  const auto etendues = sections.get<PhotonLeaf::Lanes<float>>(first + 1);
  const auto nodes = sections.get<std::byte>(first + 2);
  if (!leaves || !etendues || !nodes) return std::nullopt;
  return PhotonMap::over(head, *leaves, *etendues, *nodes, sections.owner());
}

std::shared_ptr<PhotonMaps> maps_of(const Sections& sections) {
  const auto head = sections.get<MapsHead>(0);
  if (!head || head->size() != 1) return nullptr;
  const MapsHead& told = head->front();
  auto global = map_at(sections, 1, told.global);
  auto caustic = map_at(sections, 1 + kMapSections, told.caustic);
  if (!global || !caustic) return nullptr;
  auto maps = std::make_shared<PhotonMaps>();
  maps->global = std::move(*global);
  maps->caustic = std::move(*caustic);
  maps->emitted = told.emitted;
  maps->rays = told.rays;
  maps->caustic_rays = told.caustic_rays;
  maps->ledger = told.ledger;
  maps->memory_bytes = maps->global.memory_bytes() + maps->caustic.memory_bytes();
  return maps;
}

}  // namespace

Digest map_identity(const MapKey& key) {
  Hasher hasher;
  hasher.update(is_guide_key(key) ? "gather guide" : "photon maps");
  hasher.update_value(kVersion);
  hasher.update_value(photon_stage());
  hasher.update_value(key.scene);
  hasher.update_value(key.settings.photons_per_pass);
  hasher.update_value(key.settings.seed);
  hasher.update_value(key.pass);
  hasher.update_value(key.set);
  return hasher.finish();
}

std::optional<MapFacts> read_facts(std::span<const std::byte> first_bytes, const MapKey& key) {
  if (first_bytes.size() < kFactsBytes || Sections::told_identity(first_bytes) != map_identity(key)) return std::nullopt;
  MapsHead head;
  std::memcpy(&head, first_bytes.data() + Sections::kHeadBytes, sizeof head);   // the first section
  return MapFacts{head.global.size, head.caustic.size, head.build_seconds};
}

SectionList map_sections(const PhotonMaps& maps, double build_seconds) {
  SectionList list = sections_of(maps, build_seconds);
  add_map(maps.irradiance.places(), list);
  return list;
}

std::shared_ptr<const PhotonMaps> read_photon_maps(SharedSpan file, const MapKey& key, const Execution& execution) {
  const auto sections = Sections::read(std::move(file), map_identity(key), execution);
  if (!sections || sections->count() != kMapsSections + kMapSections) return nullptr;
  auto maps = maps_of(*sections);
  if (!maps) return nullptr;
  const MapsHead& told = sections->get<MapsHead>(0)->front();
  auto places = map_at(*sections, kMapsSections, told.irradiance);
  if (!places) return nullptr;
  maps->irradiance = Irradiance(std::move(*places), told.irradiance_reach);
  maps->memory_bytes += maps->irradiance.memory_bytes();
  return maps;
}

SectionList guide_sections(const GatherGuide& guide, double build_seconds) {
  SectionList list = sections_of(*guide.pilot, build_seconds);
  list.add(guide.global.densities());
  list.add(guide.caustic.densities());
  list.add(guide.edges.segments());
  list.add(guide.edges.tree().nodes());
  return list;
}

std::shared_ptr<const GatherGuide> read_gather_guide(SharedSpan file, const MapKey& key, const Execution& execution) {
  const auto sections = Sections::read(std::move(file), map_identity(key), execution);
  if (!sections || sections->count() != kMapsSections + 4) return nullptr;
  const auto pilot = maps_of(*sections);
  const auto global = sections->get<float>(kMapsSections);
  const auto caustic = sections->get<float>(kMapsSections + 1);
  const auto segments = sections->get<Edges::Segment>(kMapsSections + 2);
  const auto nodes = sections->get<std::byte>(kMapsSections + 3);
  if (!pilot || !global || !caustic || !segments || !nodes) return nullptr;
  auto global_bandwidth = Bandwidth::over(pilot, &pilot->global, *global, sections->owner());
  auto caustic_bandwidth = Bandwidth::over(pilot, &pilot->caustic, *caustic, sections->owner());
  auto edges = Edges::over(*segments, *nodes, sections->owner());
  if (!global_bandwidth || !caustic_bandwidth || !edges) return nullptr;
  auto guide = std::make_shared<GatherGuide>();
  guide->pilot = pilot;
  guide->global = std::move(*global_bandwidth);
  guide->caustic = std::move(*caustic_bandwidth);
  guide->edges = std::move(*edges);
  guide->memory_bytes = pilot->memory_bytes + global->size_bytes() + caustic->size_bytes() + guide->edges.memory_bytes();
  return guide;
}

}  // namespace photond
