#include <gtest/gtest.h>

#include <string>

#include "server/api/contract.h"
#include "server/api/job_message.h"
#include "server/api/openapi.h"

namespace photond {
namespace {

const std::string kScene(64, 'a');

Result<Json> read(const std::string& text) { return parse_json(std::as_bytes(std::span(text.data(), text.size()))); }

/// As POST /v1/jobs does it: the schema first.
Result<JobSpec> parse(const std::string& text) {
  static const Contract contract = std::move(*Contract::read(kOpenApiText));
  const Result<Json> json = read(text);
  if (!json) return json.error();
  const Schema& schema = *contract.find("POST", "/v1/jobs")->body.at("application/json");
  for (const Violation& violation : check_value(schema, *json))
    return invalid_input(violation.detail, violation.where);
  return parse_job(*json);
}

/// A message with `fields` added to what is needed.
Result<JobSpec> parse_with(const std::string& fields) {
  return parse("{\"scene\":\"" + kScene + "\"," + fields + "}");
}

TEST(ParseJob, EveryFieldButTheSceneHasADefault) {
  const auto spec = parse("{\"scene\":\"" + kScene + "\"}");
  ASSERT_TRUE(spec.ok());
  EXPECT_EQ(to_hex(spec->scene), kScene);
  EXPECT_EQ(std::get<std::uint32_t>(spec->camera), 0u);
  EXPECT_EQ(spec->settings.width, 512);
  EXPECT_EQ(spec->settings.method, Method::automatic);
  EXPECT_EQ(spec->stop.passes, 256u);
  EXPECT_EQ(spec->stop.seconds, 60.0);
  EXPECT_EQ(spec->priority, Priority::interactive);
}

TEST(ParseJob, TheContractTellsTheDefaultsThatHold) {
  const Contract contract = std::move(*Contract::read(kOpenApiText));
  const Json& schema = contract.document()["components"]["schemas"]["JobSpec"]["properties"];
  const Json spec = spec_message(*parse("{\"scene\":\"" + kScene + "\"}"));
  for (const auto& [name, value] : spec.items()) {
    if (name == "scene" || name == "photons_per_pass") continue;   // that follows from the film
    if (name != "film") {
      EXPECT_EQ(value, schema[name]["default"]) << name;
      continue;
    }
    for (const auto& [side, length] : value.items()) EXPECT_EQ(length, schema["film"]["properties"][side]["default"]);
  }
}

TEST(ParseJob, TakesAsManyPhotonsAsTheFilmNeeds) {
  const auto photons = [](const std::string& fields) { return parse_with(fields)->photons.photons_per_pass; };
  EXPECT_EQ(photons(R"("film":{"width":1024,"height":1024})"), 1u << 20);
  EXPECT_EQ(photons(R"("film":{"width":1024,"height":1024},"photons_per_pass":5000)"), 5000u);
  EXPECT_EQ(photons(R"("label":"512 by 512")"), PhotonSettings{}.photons_per_pass);
}

TEST(ParseJob, ReadsAllFields) {
  const auto spec = parse_with(
      R"("camera":{"eye":[1,2,3],"target":[0,0,0],"up":[0,0,1],"yfov_deg":50},"film":{"width":8,"height":9},
         "method":"progressive","photons_per_pass":1000,"radius":0.5,"gather_photons":7,"seed":18446744073709551615,
         "stop":{"passes":3,"relative_error":0.1},"priority":"batch","label":"mine")");
  ASSERT_TRUE(spec.ok()) << spec.error().message;
  EXPECT_EQ(std::get<LookAt>(spec->camera).eye, Vec3(1, 2, 3));
  EXPECT_EQ(spec->settings.height, 9);
  EXPECT_EQ(spec->settings.method, Method::progressive);
  EXPECT_EQ(spec->photons.photons_per_pass, 1000u);
  EXPECT_EQ(spec->settings.radius, 0.5f);
  EXPECT_EQ(spec->settings.gather_photons, 7u);
  EXPECT_EQ(spec->photons.seed, UINT64_MAX);
  EXPECT_EQ(spec->settings.seed, UINT64_MAX);
  EXPECT_EQ(spec->stop.passes, 3u);
  EXPECT_FALSE(spec->stop.seconds);
  EXPECT_EQ(spec->priority, Priority::batch);
  EXPECT_EQ(spec->label, "mine");
}

TEST(ParseJob, ReadsBackWhatItWrites) {
  const auto spec = parse_with(R"("camera":"c","method":"path","stop":{"seconds":1.5},"label":"x")");
  ASSERT_TRUE(spec.ok());
  const auto again = parse(to_text(spec_message(*spec)));
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ(to_text(spec_message(*again)), to_text(spec_message(*spec)));
}

TEST(ParseJob, NamesTheFieldThatIsWrong) {
  const std::pair<const char*, const char*> cases[] = {
      {R"("film":{"width":0})", "/film/width"},
      {R"("film":{"width":-1})", "/film/width"},
      {R"("film":{"width":1.5})", "/film/width"},
      {R"("film":{"height":"9"})", "/film/height"},
      {R"("film":{"depth":9})", "/film/depth"},
      {R"("film":7)", "/film"},
      {R"("camera":-1)", "/camera"},
      {R"("camera":[1])", "/camera"},
      {R"("camera":{"eye":[1,2],"target":[0,0,0]})", "/camera/eye"},
      {R"("camera":{"eye":[1,2,1e39],"target":[0,0,0]})", "/camera/eye/2"},
      {R"("camera":{"eye":[1,2,3]})", "/camera/target"},
      {R"("camera":{"eye":[1,2,3],"target":[1,2,3]})", "/camera/target"},
      {R"("camera":{"eye":[0,2,0],"target":[0,0,0]})", "/camera/up"},
      {R"("camera":{"eye":[1,2,3],"target":[0,0,0],"yfov_deg":180})", "/camera/yfov_deg"},
      {R"("method":"magic")", "/method"},
      {R"("photons_per_pass":0)", "/photons_per_pass"},
      {R"("photons_per_pass":100000001)", "/photons_per_pass"},
      {R"("radius":-1)", "/radius"},
      {R"("radius":1e300)", "/radius"},
      {R"("gather_photons":5000)", "/gather_photons"},
      {R"("seed":-1)", "/seed"},
      {R"("stop":{})", "/stop"},
      {R"("stop":{"passes":0})", "/stop/passes"},
      {R"("stop":{"seconds":0})", "/stop/seconds"},
      {R"("stop":{"seconds":"1"})", "/stop/seconds"},
      {R"("stop":{"relative_error":-0.1})", "/stop/relative_error"},
      {R"("stop":{"passes":null,"seconds":1})", "/stop/passes"},
      {R"("priority":"high")", "/priority"},
      {R"("label":5)", "/label"},
      {R"("a/b~c":5)", "/a~1b~0c"},
      {R"("scene2":5)", "/scene2"}};
  for (const auto& [fields, pointer] : cases) {
    const auto spec = parse_with(fields);
    ASSERT_FALSE(spec.ok()) << fields;
    EXPECT_EQ(spec.error().where, pointer) << fields;
  }
  EXPECT_EQ(parse("{}").error().where, "/scene");
  EXPECT_EQ(parse(R"({"scene":"abc"})").error().where, "/scene");
}

TEST(ParseJson, RefusesWhatTheLibraryWouldLetPass) {
  const auto refuses = [](const std::string& text) {
    return !read(text).ok() && read(text).error().where.empty();
  };
  EXPECT_TRUE(refuses(""));
  EXPECT_TRUE(refuses("{"));
  EXPECT_TRUE(refuses("{} x"));
  EXPECT_TRUE(refuses("{\"a\":\"\xff\"}"));
  EXPECT_TRUE(refuses(std::string(200'000, '[')));
  EXPECT_TRUE(refuses(std::string(200'000, '[') + std::string(200'000, ']')));
  const auto twice = parse(R"({"seed":1,"seed":2})");
  ASSERT_FALSE(twice.ok());
  EXPECT_NE(twice.error().message.find("\"seed\" appears twice"), std::string::npos);
}

TEST(SeriesMessage, OnlyGrowsThoughAJobWentOnFromFurtherBack) {
  JobRecord job;
  job.passes = 8;
  job.series = {{1, 1, 1, {}}, {2, 4, 3, {}}, {3, 7, 6, {}}, {4, 9, 8, {}}, {5, 5, 4, {}}, {6, 8, 3.5, {}}};
  const auto revisions = [&] {
    std::vector<int> all;
    const Json message = series_message(job);
    for (const Json& point : message["points"]) all.push_back(point["revision"]);
    return all;
  };
  EXPECT_EQ(revisions(), (std::vector<int>{1, 2, 6}));
  job.series.pop_back();
  EXPECT_EQ(revisions(), (std::vector<int>{1, 2, 5}));
  job.series.pop_back();
  EXPECT_EQ(revisions(), (std::vector<int>{1, 2, 3})) << "nothing was published since";
}

}  // namespace
}  // namespace photond
