using System.Runtime.CompilerServices;

[assembly: InternalsVisibleTo("Lumivox.Editor")]
[assembly: InternalsVisibleTo("Lumivox.EditMode.Tests")]
[assembly: InternalsVisibleTo("Lumivox.PlayMode.Tests")]
[assembly: InternalsVisibleTo("Lumivox.Tests")]
