using System.Runtime.CompilerServices;

[assembly: InternalsVisibleTo("StandIn.Tests.Program")]
