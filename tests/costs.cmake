# What the longest tests of the binaries, and the longest suites without them, take [s], so that ctest starts them first where
# it has no record of its own, as in a fresh clone. Tests that are no binaries have theirs beside them.
set(costs
    libhybrid/solvers/Certificate.NoneIsFalseOnAThousandGraphs:25
    faults/ExperimentFaults.LosesAndDoublesNoTrialHoweverItIsStopped:23
    libhybrid/maps/FindPlace.FindsARobotAnywhereInThePlane:19
    libhybrid/maps/FindPlace.RowsOfParkedCarsOfTheSameTownAreFound:18
    faults/ProgramFaults.PoseGraph:16
    apps/Tries.AnswerAsThePageSays:15
    faults/MapFaults.AMapOutlivesBeingKilled:15
    faults/ReplayFaults.AnAllocationThatFails:15
    faults/ProgramFaults.AnOnlinePoseGraphThatIsStoppedWritesWhatItHas:14
    libhybrid/maps/JoinMaps.MakesCommonLandmarksOne:14
    faults/ReplayFaults.KilledAtAnyCallOfTheDiskItIsTheOldResultOrTheNewOne:13
    faults/ProgramFaults.Simulation:13
    apps/RanksTest.ADeadOneLosesOnlyItsTrial:13
    apps/PrintedConfig.ReadsBackFromAnyFolder:12
    faults/MapFaults.OutAndMapAppearTogetherOrNotAtAll:11
    faults/MapFaults.AMapOutlivesAFullDisk:10
    faults/ReplayFaults.ACallOfTheDiskThatFails:10
    apps/ReplayTest.ASignalEndsAPluginThatWaitsForEver:19)
