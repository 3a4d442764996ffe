using System.Runtime.CompilerServices;

[assembly: InternalsVisibleTo("Lumivox.Tests")]
[assembly: InternalsVisibleTo("StandIn.Tests.Program")]
