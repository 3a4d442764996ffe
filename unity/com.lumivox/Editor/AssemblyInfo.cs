using System.Runtime.CompilerServices;

[assembly: InternalsVisibleTo("Lumivox.Tests")]
[assembly: InternalsVisibleTo("Lumivox.EditMode.Tests")]
