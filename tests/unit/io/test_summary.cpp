#include <limits>

#include "base/error.hpp"
#include "io/summary.hpp"
#include "temporary_folder.hpp"

namespace berm {
namespace {

class SummaryFile : public TemporaryFolder {};

TEST_F(SummaryFile, HoldsEverything) {
  Summary s;
  s.title = "A \"quoted\" title\\\n\x01 \xc3\xa9";
  s.method = "mpm";
  s.case_file = "case.toml";
  s.status = "done";
  s.dofs = 12;
  s.points = 34;
  s.steps = 5;
  s.wall_seconds = 1.5;
  s.thickness = 0.1;
  s.dimension = 3;
  s.axisymmetric = true;
  s.processes = 4;
  s.origin = {"0.1.0", "abc123", "here", "berm run 'a b.toml'"};
  s.references = {{.file = "/a/b.csv"}, {"/c.csv", "u [mm]", "F \"1\" [kN]", ";", ""}};
  s.body_rings["disc"] = {{Vec2(0, 0), Vec2(1, 0), Vec2(0.5, 2)}, {Vec2(0.25, 0.25)}};
  s.body_rings["top"] = {};
  s.body_surfaces = {{"ball", "surfaces/ball.vtu"}, {"a \"quoted\" one", "b.vtu"}};
  s.rigid_motion = {{"top", {{0.0, 0.0, 0.0, 0.0}, {0.5, 0.0, -0.25, 0.0}}}};
  s.metrics = {{"peak_load [N]", 2.5e6}, {"stress_noise [-]", std::numeric_limits<double>::quiet_NaN()}};
  write_summary(path("summary.json"), s);
  EXPECT_EQ(content(path("summary.json")), R"({
  "title": "A \"quoted\" title\\\n\u0001 é",
  "method": "mpm",
  "case": "case.toml",
  "status": "done",
  "reason": "",
  "dofs": 12,
  "points": 34,
  "steps": 5,
  "cut_steps": 0,
  "newton_iterations": 0,
  "wall_seconds": 1.5,
  "thickness": 0.1,
  "dimension": 3,
  "axisymmetric": true,
  "processes": 4,
  "version": "0.1.0",
  "commit": "abc123",
  "host": "here",
  "command": "berm run 'a b.toml'",
  "references": ["/a/b.csv", {"file": "/c.csv", "x": "u [mm]", "y": "F \"1\" [kN]", "delimiter": ";", "label": ""}],
  "body_rings": {
    "disc": [[[0, 0], [1, 0], [0.5, 2]], [[0.25, 0.25]]],
    "top": []
  },
  "body_surfaces": {
    "a \"quoted\" one": "b.vtu",
    "ball": "surfaces/ball.vtu"
  },
  "rigid_motion": {
    "top": [[0, 0, 0, 0], [0.5, 0, -0.25, 0]]
  },
  "metrics": {
    "peak_load [N]": 2500000,
    "stress_noise [-]": null
  }
}
)");
}

TEST_F(SummaryFile, EmptyIsValidJson) {
  const std::string json = summary_json(Summary{});
  EXPECT_NE(json.find("\"body_rings\": {},\n  \"body_surfaces\": {},\n  \"rigid_motion\": {},\n  \"metrics\": {}\n}"), std::string::npos);
  EXPECT_NE(json.find("\"dimension\": 2,\n  \"axisymmetric\": false,\n  \"processes\": 1,\n"), std::string::npos);
}

TEST_F(SummaryFile, FailureNamesTheFile) {
  EXPECT_THROW(write_summary(path("no_such_folder/summary.json"), Summary{}), RunError);
}

}  // namespace
}  // namespace berm
