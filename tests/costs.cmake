# What the longest tests of the binaries take [s], so that ctest starts them first where it has no record of its own, as in a
# fresh clone. Tests that are no binaries have theirs beside them.
foreach(entry Certificate.NoneIsFalseOnAThousandGraphs:25
        ExperimentFaults.LosesAndDoublesNoTrialHoweverItIsStopped:23
        FindPlace.FindsARobotAnywhereInThePlane:19 FindPlace.RowsOfParkedCarsOfTheSameTownAreFound:18 ProgramFaults.PoseGraph:16
        Tries.AnswerAsThePageSays:15 MapFaults.AMapOutlivesBeingKilled:15 ReplayFaults.AnAllocationThatFails:15
        ProgramFaults.AnOnlinePoseGraphThatIsStoppedWritesWhatItHas:14 JoinMaps.MakesCommonLandmarksOne:14
        ReplayFaults.KilledAtAnyCallOfTheDiskItIsTheOldResultOrTheNewOne:13 ProgramFaults.Simulation:13
        RanksTest.ADeadOneLosesOnlyItsTrial:13 PrintedConfig.ReadsBackFromAnyFolder:12
        MapFaults.OutAndMapAppearTogetherOrNotAtAll:11 MapFaults.AMapOutlivesAFullDisk:10)
  string(REPLACE ":" ";" entry ${entry})
  list(GET entry 0 test)
  list(GET entry 1 seconds)
  set_tests_properties(${test} PROPERTIES COST ${seconds})
endforeach()
