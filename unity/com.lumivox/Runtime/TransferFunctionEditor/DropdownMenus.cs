using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox
{
    /// <summary>Menus that are as wide as their words.</summary>
    static class DropdownMenus
    {
        public static void Open(GenericDropdownMenu menu, Rect at, VisualElement of)
        {
#if UNITY_6000_3_OR_NEWER
            menu.DropDown(at, of, DropdownMenuSizeMode.Content);
#else
            menu.DropDown(at, of, false);
#endif
        }
    }
}
