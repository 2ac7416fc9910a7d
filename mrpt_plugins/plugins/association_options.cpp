// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/plugins/association_options.h"

namespace hybrid {

AssociationOptions read_association_options(IniSection& section) {
  AssociationOptions o;
  const std::string method = section.choice(
      "method", "hypotheses", {"hypotheses", "nearest", "jcbb"},
      "hypotheses: the best joint matchings of a frame, kept open while they are close; nearest: "
      "maximum likelihood, detection by detection; jcbb: joint compatibility branch and bound");
  using Method = AssociationOptions::Method;
  if (method == "nearest") o.method = Method::kNearest;
  if (method == "jcbb") o.method = Method::kJcbb;
  o.use_ids = section.get("use_ids", o.use_ids, "take the ids of the log where it has them");
  o.gate = section.get("gate", o.gate, "probability of the chi-square gate of an innovation",
                       IniRange{0.5, 0.999999});
  section.replaces("information_penalty", "caution");
  o.caution = section.get("information_penalty", o.caution,
                          "price of a match, in -log odds, for each nat that it would tell of pose "
                          "and landmark: the less these are known, the better it must fit",
                          IniRange{0, 1e3});
  o.hypotheses = section.get("hypotheses", o.hypotheses, "joint matchings kept open for a frame",
                             IniRange{1, 64});
  o.open_odds = section.get("open_odds", o.open_odds,
                            "matchings are kept open that are less probable than the best by at "
                            "most this factor",
                            IniRange{1, 1e9});
  o.window = section.get("window", o.window, "keyframes until an open matching is decided",
                         IniRange{1, 1e6});
  o.landmarks_in_view = section.get("landmarks_in_view", o.landmarks_in_view,
                                    "landmarks expected in the field of view, before any is known",
                                    IniRange{1e-3, 1e6});
  o.clutter_in_view = section.get("clutter_in_view", o.clutter_in_view,
                                  "spurious detections expected in a frame", IniRange{1e-6, 1e6});
  o.detection_probability =
      section.get("detection_probability", o.detection_probability,
                  "that a landmark in view is detected", IniRange{0.01, 0.99});
  o.confirm = section.get("confirm", o.confirm,
                          "sightings until a landmark counts; until then it is tentative, and in "
                          "the end it is clutter",
                          IniRange{1, 1e6});
  o.merge = section.get("merge", o.merge, "find landmarks that are one, and so close loops");
  o.recent = section.get("recent", o.recent,
                         "landmarks seen within so many keyframes are compared with the others",
                         IniRange{1, 1e6});
  o.merge_odds = section.get("merge_odds", o.merge_odds,
                             "evidence needed for a merge, and over one that contradicts it",
                             IniRange{1, 1e12});
  return o;
}

}  // namespace hybrid
