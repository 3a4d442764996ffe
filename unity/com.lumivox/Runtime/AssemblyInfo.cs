using System.Runtime.CompilerServices;

[assembly: InternalsVisibleTo("Lumivox.Universal")]
[assembly: InternalsVisibleTo("Lumivox.HighDefinition")]
[assembly: InternalsVisibleTo("Lumivox.Editor")]
[assembly: InternalsVisibleTo("Lumivox.SelfCheck")]
[assembly: InternalsVisibleTo("Lumivox.PlayMode.Tests")]
[assembly: InternalsVisibleTo("Lumivox.Tests")]
[assembly: InternalsVisibleTo("StandIn.Tests.Program")]
