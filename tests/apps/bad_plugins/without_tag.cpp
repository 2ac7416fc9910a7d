// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A plugin registered as MRPT does it, which does not say what it was built for.

#include "mrpt_plugins/mapping/mapping_plugin.h"

namespace example {

class WithoutTag : public hybrid::MappingPlugin {
  DEFINE_MRPT_OBJECT(WithoutTag, example)

 public:
  void configure(hybrid::IniSection) override {}
  hybrid::Contribution observe(const hybrid::Frame&, const hybrid::MapView&) override { return {}; }
};

}  // namespace example

IMPLEMENTS_MRPT_OBJECT(WithoutTag, hybrid::MappingPlugin, example)

[[maybe_unused]] static const bool is_registered = [] {
  mrpt::rtti::registerClass(CLASS_ID(example::WithoutTag));
  return true;
}();
